#include "tagcal/io/text_file.hpp"

#include <fmt/format.h>

#include <optional>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal {
using namespace internal;
namespace {

// Appends the text between the quote that `line` begins with and its end to `text`. Returns the
// number of characters with both quotes; no value without an end.
std::optional<std::size_t> unquote(std::string_view line, std::string& text) {
  for (std::size_t i = 1; i < line.size(); ++i) {
    if (line[i] == '"' && (i + 1 == line.size() || line[i + 1] != '"')) return i + 1;
    if (line[i] == '"') ++i;
    text += line[i];
  }
  return std::nullopt;
}

}  // namespace

std::string_view trimmed(std::string_view text, std::string_view blanks) {
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

bool is_image_name(std::string_view image) {
  return !image.empty() && image.find_first_of("\r\n") == std::string_view::npos;
}

std::string image_field(const std::string& image) {
  if (!is_image_name(image))
    throw Error(fmt::format("image: must be a name of one line, got {}", shown(image)));
  return csv_field(image);
}

std::string csv_field(std::string_view text) {
  const bool is_plain =
      text.find_first_of(",\"") == text.npos && trimmed(text) == text && !text.starts_with('#');
  if (is_plain) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

std::string_view CsvFields::split(std::string_view line) {
  fields_.clear();
  unquoted_.clear();
  for (;;) {
    line = trimmed(line);
    if (line.starts_with('"')) {
      const auto length = unquote(line, unquoted_.emplace_back());
      if (!length) return "the closing quote is missing";
      fields_.push_back(unquoted_.back());
      line = trimmed(line.substr(*length));
      if (!line.empty() && line[0] != ',') return "text after the closing quote";
    } else {
      fields_.push_back(trimmed(line.substr(0, line.find(','))));
    }
    const std::size_t comma = line.find(',');
    if (comma == line.npos) return "";
    line.remove_prefix(comma + 1);
  }
}

}  // namespace tagcal
