#pragma once

#include <optional>
#include <string_view>
#include <utility>

#include "tagcal/io/text/number_text.hpp"

namespace tagcal::internal {

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
