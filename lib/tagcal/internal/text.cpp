#include "tagcal/internal/text.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace tagcal::internal {
namespace {

std::string printed(double value, std::chars_format format, int precision) {
  std::string text(static_cast<std::size_t>(precision) + 330, '\0');  // %f of 1e308 has 309 digits
  const auto written =
      std::to_chars(text.data(), text.data() + text.size(), value, format, precision);
  text.resize(static_cast<std::size_t>(written.ptr - text.data()));
  return text;
}

}  // namespace

std::string with_digits(double value, int significant_digits) {
  return printed(value, std::chars_format::general, significant_digits);
}

std::string with_decimals(double value, int decimals) {
  return printed(value, std::chars_format::fixed, decimals);
}

std::string with_sigma(double value, double sigma) {
  if (!(sigma > 0 && std::isfinite(sigma))) return short_number(value);
  const int decimals = std::max(0, 1 - static_cast<int>(std::floor(std::log10(sigma))));
  return with_decimals(value, decimals) + " +- " + with_decimals(sigma, decimals);
}

std::string short_number(double value) { return with_digits(value, 6); }

std::string percent(double share) {
  if (!(share <= 10)) return "more than 1000 %";
  return std::to_string(std::lround(100 * share)) + " %";
}

std::string listed(std::span<const std::string> names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 < names.size() ? ", " : " and ") + names[i];
  return text;
}

std::string side_name(int x, int y, const char* middle) {
  const std::string vertical = y < 0 ? "upper" : y > 0 ? "lower" : "";
  const std::string horizontal = x < 0 ? "left" : x > 0 ? "right" : "";
  if (vertical.empty() && horizontal.empty()) return middle;
  return vertical + (vertical.empty() || horizontal.empty() ? "" : " ") + horizontal;
}

}  // namespace tagcal::internal
