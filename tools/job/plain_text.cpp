#include "job/plain_text.hpp"

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>

#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::ordered_json;

Json field_json(std::string_view field, bool is_text) {
  if (field.empty()) return {};
  if (is_text) return Json(field);
  if (const auto whole = number_of<std::int64_t>(field)) return *whole;  // ids and counts
  if (const auto number = number_of<double>(field)) return *number;
  return Json(field);
}

}  // namespace

std::string json_text(const Json& value, int indent) {
  return value.dump(indent, ' ', false, Json::error_handler_t::replace) + "\n";
}

nlohmann::ordered_json rows_json(std::string_view csv, const std::vector<std::string>& texts) {
  CsvFields cells;
  std::vector<std::string> names;
  std::vector<bool> is_text;
  Json rows = Json::array();
  for_each_line(csv, [&](std::string_view line, std::size_t) {
    cells.split(line);
    const auto& fields = cells.fields();
    if (names.empty()) {
      names.assign(fields.begin(), fields.end());
      for (const std::string& name : names) is_text.push_back(std::ranges::count(texts, name) > 0);
      return;
    }
    Json row;
    for (std::size_t i = 0; i < std::min(names.size(), fields.size()); ++i)
      row[names[i]] = field_json(fields[i], is_text[i]);
    rows.push_back(std::move(row));
  });
  return rows;
}

std::string one_line_text(std::string_view text) {
  auto line = Json::parse(json_text(text)).get<std::string>();
  const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7f; };
  std::ranges::replace_if(line, is_control, '?');
  return line;
}

std::string xml_text(std::string_view text) {
  std::string result;
  for (const char c : one_line_text(text)) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += c;
  }
  // The two characters of UTF-8 that XML does not allow.
  for (const std::string_view bad : {"\uFFFE", "\uFFFF"})
    for (std::size_t at = 0; (at = result.find(bad, at)) != std::string::npos;)
      result.replace(at, bad.size(), "\uFFFD");
  return result;
}

}  // namespace tagcal::tools
