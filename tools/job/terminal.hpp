#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

// Text for a person at a terminal: as wide as the terminal, numbers with the digits that their
// standard deviations leave, colour only where stdout is a terminal.

namespace tagcal::tools {

inline constexpr std::size_t kMostColumns = 100;

// The columns that a person sees of stdout or stderr: COLUMNS, else the terminal's, at most
// kMostColumns. Nothing if neither says so: a file or a pipe.
std::optional<std::size_t> columns_of_stream(int stream);

// The columns of results: those of stdout, else of stderr, else kMostColumns.
std::size_t text_columns();

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

// The text with each line that is longer than `columns` wrapped. What follows the first line of it
// stands below the text behind a label ("rms    0.2 px"), or is indented by 2 more blanks.
std::string fitted(std::string_view text, std::size_t columns);

// "1 picture", "2 pictures"
std::string counted(std::size_t count, std::string_view what);

// A number and its standard deviation as text, both with the decimals that show two significant
// digits of the latter. Without one (0, infinite or NaN) the number has six significant digits.
struct Measured {
  std::string value;
  std::string sigma;  // "" for 0 and NaN
};
Measured measured(double value, double sigma);
std::string with_sigma(double value, double sigma);  // "110.01 +- 0.16"

// A length that is its own standard deviation: two significant digits.
std::string two_digits(double value);

}  // namespace tagcal::tools
