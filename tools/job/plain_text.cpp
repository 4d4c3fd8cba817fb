#include "job/plain_text.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tagcal::tools {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

std::string json_text(const Json& value, int indent) {
  return value.dump(indent, ' ', false, Json::error_handler_t::replace) + "\n";
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
