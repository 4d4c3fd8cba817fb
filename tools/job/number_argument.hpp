#pragma once

#include <charconv>
#include <optional>
#include <string_view>

namespace tagcal::tools {

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
