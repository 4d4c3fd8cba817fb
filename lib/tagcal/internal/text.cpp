#include "tagcal/internal/text.hpp"

#include <cmath>

namespace tagcal::internal {

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

}  // namespace tagcal::internal
