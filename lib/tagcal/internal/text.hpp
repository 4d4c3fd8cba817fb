#pragma once

#include <span>
#include <string>

// Numbers and lists for sentences.

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

}  // namespace tagcal::internal
