#pragma once

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

// Numbers and lists as text, and back.

namespace tagcal::internal {

// As printf's %.*g and %.*f write a number with a decimal point, in any locale of the program.
std::string with_digits(double value, int significant_digits);
std::string with_decimals(double value, int decimals);
std::string short_number(double value);  // %g: six digits at most
// "184 +- 36": both to the place of the second digit of the standard deviation. Without one (0,
// infinite or NaN) the value alone.
std::string with_sigma(double value, double sigma);

std::string percent(double share);                       // "12 %", "more than 1000 %"
std::string listed(std::span<const std::string> names);  // "a, b and c"

// The name of a third or a side of an image: (-1, -1) is "upper left", (0, 0) `middle`.
std::string side_name(int x, int y, const char* middle);

// The texts of items with a separator between them; `text_of`: a member or a function.
template <typename Items, typename TextOf = std::identity>
std::string joined(const Items& items, std::string_view separator, const TextOf& text_of = {}) {
  std::string all;
  for (const auto& item : items)
    all.append(all.empty() ? "" : separator).append(std::invoke(text_of, item));
  return all;
}

// Parses a decimal number, with or without a sign; no value if `text` has anything else.
template <typename T>
std::optional<T> parsed(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}
inline std::optional<int> parse_whole(std::string_view text) { return parsed<int>(text); }
inline std::optional<double> parse_number(std::string_view text) {  // finite
  const auto value = parsed<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

// The shortest text that reads back as the same double.
inline std::string number_text(double value) { return fmt::format("{}", value); }

// Text from a file, made printable in a message of one line.
inline std::string shown(std::string_view text) {
  constexpr std::size_t kMost = 60;  // bytes; numeric: a value fits into a line of a terminal
  std::string line;
  for (const char c : text.substr(0, kMost)) {
    const auto byte = static_cast<unsigned char>(c);
    line += byte < 0x20 || byte == 0x7f ? '?' : c;
  }
  if (text.size() > kMost) line += "...";
  return line;
}

// Parses a length in metres: a number, or one with a unit behind it (30mm, 3 cm, 0.03m, 1in). No
// value if `text` has anything else.
inline std::optional<double> parse_length(std::string_view text) {
  constexpr std::pair<std::string_view, double> kUnits[] = {
      {"mm", 1e-3}, {"cm", 1e-2}, {"in", 0.0254}, {"ft", 0.3048}, {"m", 1}};
  for (const auto& [unit, metres] : kUnits) {
    if (!text.ends_with(unit)) continue;
    text.remove_suffix(unit.size());
    while (text.ends_with(' ')) text.remove_suffix(1);
    const auto number = parse_number(text);
    // A quotient of whole powers of ten is the double that the same length in metres reads as.
    if (!number) return std::nullopt;
    return metres < 0.02 ? *number / (1 / metres) : *number * metres;
  }
  return parse_number(text);
}

}  // namespace tagcal::internal
