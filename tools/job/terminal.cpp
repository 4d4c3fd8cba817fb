#include "job/terminal.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace tagcal::tools {
namespace {

bool shows_colour() {
  const char* const no_colour = std::getenv("NO_COLOR");
  const char* const terminal = std::getenv("TERM");
  const bool is_dumb = terminal != nullptr && std::string_view(terminal) == "dumb";
  return isatty(STDOUT_FILENO) == 1 && !is_dumb && (no_colour == nullptr || *no_colour == '\0');
}

// Of ECMA-48: bold and a colour, and the end of both.
constexpr std::string_view kToneBegins = "\033[1;3", kToneEnds = "\033[0m";

// Bytes of the code of `toned` at the start of a text.
std::size_t tone_length(std::string_view text) {
  if (text.starts_with(kToneEnds)) return kToneEnds.size();
  const std::size_t length = kToneBegins.size() + 2;  // a digit and "m"
  return text.starts_with(kToneBegins) && text.substr(0, length).ends_with('m') ? length : 0;
}

// Bytes of the control character at the start of a text: C0, delete, or C1 in UTF-8.
std::size_t control_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (byte(0) < 0x20) return text[0] == '\n' || text[0] == '\t' ? 0 : 1;
  if (byte(0) == 0xc2 && text.size() > 1) return byte(1) >= 0x80 && byte(1) < 0xa0 ? 2 : 0;
  return byte(0) == 0x7f ? 1 : 0;
}

// Decimals that show two significant digits of a number after rounding; at most 12.
int decimals_of(double value) {
  const std::string rounded = fmt::format("{:.1e}", value);  // "9.9e-03"
  const int exponent = std::stoi(rounded.substr(rounded.find('e') + 1));
  return std::clamp(1 - exponent, 0, 12);
}

// Of the last line.
std::size_t visible_width(std::string_view text) {
  return without_colours(text.substr(text.rfind('\n') + 1)).size();
}

std::string wrapped_to(std::size_t columns, std::string_view first, std::string_view text,
                       std::size_t indent) {
  std::string result(first);
  std::size_t column = visible_width(first);
  bool line_has_word = false;
  std::size_t blanks = 1;  // before the word: more than one in a table
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    const std::string_view word = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (word.empty()) {
      ++blanks;
      continue;
    }
    if (line_has_word && column + blanks + visible_width(word) > columns) {
      result += "\n" + std::string(indent, ' ');
      column = indent;
      line_has_word = false;
    }
    const std::size_t gap = line_has_word ? blanks : 0;
    result += std::string(gap, ' ');
    result += word;
    column += gap + visible_width(word);
    line_has_word = true;
    blanks = 1;
  }
  return result + "\n";
}

// Bytes of a label and the two blanks or more behind it, with which a line begins; 0: none.
std::size_t indent_of_label(std::string_view line) {
  const std::size_t begin = std::min(line.find_first_not_of(' '), line.size());
  const std::size_t gap = line.find("  ", begin);
  return gap == line.npos ? 0 : std::min(line.find_first_not_of(' ', gap), line.size());
}

std::size_t indent_of_rest(std::string_view line, std::size_t columns) {
  const std::size_t label = visible_width(line.substr(0, indent_of_label(line)));
  if (label > 0 && label <= columns / 2) return label;
  return std::min(line.find_first_not_of(' '), columns / 2) + 2;
}

}  // namespace

std::string toned(Tone tone, std::string_view text) {
  static const bool colour = shows_colour();
  if (!colour) return std::string(text);
  const int code = tone == Tone::good ? 2 : tone == Tone::caution ? 3 : 1;
  return fmt::format("{}{}m{}{}", kToneBegins, code, text, kToneEnds);
}

// The codes run from ESC to "m".
std::string without_colours(std::string_view text) {
  std::string plain;
  bool is_code = false;
  for (const char c : text) {
    if (c == '\033') is_code = true;
    if (!is_code) plain += c;
    if (c == 'm') is_code = false;
  }
  return plain;
}

std::string without_controls(std::string_view text) {
  std::string plain;
  while (!text.empty()) {
    const std::size_t tone = tone_length(text), control = tone == 0 ? control_length(text) : 0;
    const std::size_t length = std::max<std::size_t>(1, tone + control);
    plain += control > 0 ? "?" : text.substr(0, length);
    text.remove_prefix(length);
  }
  return plain;
}

std::optional<std::size_t> columns_of_stream(int stream) {
  constexpr std::size_t kLeast = 20;  // a narrower terminal wraps words itself
  std::size_t columns = 0;
  const char* const stated = std::getenv("COLUMNS");
  const std::string_view text = stated == nullptr ? "" : stated;
  std::from_chars(text.data(), text.data() + text.size(), columns);
  if (winsize size{}; columns == 0 && isatty(stream) == 1 && ioctl(stream, TIOCGWINSZ, &size) == 0)
    columns = size.ws_col;
  if (columns == 0) return std::nullopt;
  return std::clamp(columns, kLeast, kMostColumns);
}

std::size_t text_columns() {
  static const std::optional<std::size_t> seen = columns_of_stream(STDOUT_FILENO);
  static const std::size_t columns =
      seen ? *seen : columns_of_stream(STDERR_FILENO).value_or(kMostColumns);
  return columns;
}

std::string wrapped(std::string_view first, std::string_view text, std::size_t indent) {
  return wrapped_to(text_columns(), first, text, indent);
}

std::string fitted(std::string_view text, std::size_t columns) {
  std::string result;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    const bool is_whole = end < text.size();
    text.remove_prefix(end + (is_whole ? 1 : 0));
    if (visible_width(line) <= columns) {
      result += line;
      result += is_whole ? "\n" : "";
      continue;
    }
    const std::size_t indent = indent_of_rest(line, columns);
    const std::size_t begin = std::min(line.find_first_not_of(' '), line.size());
    const std::size_t label = std::max(begin, indent_of_label(line));
    result += wrapped_to(columns, line.substr(0, label), line.substr(label), indent);
    if (!is_whole) result.pop_back();
  }
  return result;
}

std::string counted(std::size_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

Measured measured(double value, double sigma) {
  if (!(sigma > 0) || !std::isfinite(sigma))
    return {fmt::format("{:.6g}", value), std::isinf(sigma) ? "no bound" : ""};
  const int decimals = decimals_of(sigma);
  return {fmt::format("{:.{}f}", value, decimals), fmt::format("{:.{}f}", sigma, decimals)};
}

std::string with_sigma(double value, double sigma) {
  const Measured m = measured(value, sigma);
  return m.sigma.empty() ? m.value : m.value + " +- " + m.sigma;
}

std::string two_digits(double value) {
  constexpr double kSmallest = 1e-7;  // numeric: below it, zeros would hide the size
  if (!(std::abs(value) >= kSmallest) || !std::isfinite(value)) return fmt::format("{:.2g}", value);
  return fmt::format("{:.{}f}", value, decimals_of(value));
}

}  // namespace tagcal::tools
