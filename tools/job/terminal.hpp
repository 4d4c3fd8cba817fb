#pragma once

#include <cstddef>
#include <string>
#include <string_view>

// Text for a person at a terminal: at most 100 columns wide, numbers with the digits that their
// standard deviations leave, colour only where stdout is a terminal.

namespace tagcal::tools {

inline constexpr std::size_t kTextColumns = 100;

enum class Tone {
  good,     // green
  caution,  // yellow
  bad,      // red
};

// The text in the colour of the tone, if stdout is a terminal that shows colours; not with NO_COLOR
// (https://no-color.org), nor with TERM=dumb.
std::string toned(Tone tone, std::string_view text);

// The text without the codes that `toned` adds.
std::string without_colours(std::string_view text);

// The text with a "?" for each control character that a terminal would obey: names of files and of
// keys may have any. Line ends, tabs and the codes of `toned` stay.
std::string without_controls(std::string_view text);

// Words from `first` on, wrapped at blanks; the lines after the first begin with `indent` blanks.
// `first` and `text` are one text without a blank between them. A word longer than a line stays
// whole.
std::string wrapped(std::string_view first, std::string_view text, std::size_t indent);

// "1 picture", "2 pictures"
std::string counted(std::size_t count, std::string_view what);

// A number and its standard deviation as text, both with the decimals that show two significant
// digits of the latter. Without one (0, infinite or NaN) the number has six significant digits.
struct Measured {
  std::string value;
  std::string sigma;  // "" for 0 and NaN
};
Measured measured(double value, double sigma);

// A length that is its own standard deviation: two significant digits.
std::string two_digits(double value);

}  // namespace tagcal::tools
