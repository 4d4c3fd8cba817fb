#include "tagcal/io/text/csv_image.hpp"

#include <fmt/format.h>

#include "tagcal/error.hpp"
#include "tagcal/io/text/number_text.hpp"

namespace tagcal::internal {

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
  if (image.find_first_of(",\"") == std::string::npos && trimmed(image) == image) return image;
  std::string quoted = "\"";
  for (const char c : image) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

}  // namespace tagcal::internal
