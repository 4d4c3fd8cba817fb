#pragma once

#include <charconv>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// Text of files and other programs. Names of pictures are bytes: they may have line ends, control
// characters, and bytes that are not UTF-8.

namespace tagcal::tools {

// JSON with a line end. What is not UTF-8 becomes U+FFFD. An indent of -1: all in one line.
std::string json_text(const nlohmann::ordered_json& value, int indent = 2);

// The rows of CSV with a header, each an object: numbers, and null for an empty field. `texts`: the
// columns whose fields stay texts whatever they look like, because 007 and 7 are two names.
nlohmann::ordered_json rows_json(std::string_view csv, const std::vector<std::string>& texts);

// The text as one line of UTF-8: "?" for each control character, U+FFFD as in JSON.
std::string one_line_text(std::string_view text);

// The same for the content of an element of XML, or of an attribute in double quotes.
std::string xml_text(std::string_view text);

// The number that is all of a text, in the C locale, without blanks or a plus sign; "nan" and "inf"
// are numbers.
template <typename T>
std::optional<T> number_of(std::string_view text) {
  T value{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end ? std::optional(value) : std::nullopt;
}

}  // namespace tagcal::tools
