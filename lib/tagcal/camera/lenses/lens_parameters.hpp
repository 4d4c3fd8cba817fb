#pragma once

#include <cmath>
#include <string>

#include "tagcal/camera/lens.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {

// The range of a parameter, behind "must be".
inline std::string range_text(const LensParameter& parameter) {
  if (!std::isfinite(parameter.least)) return "a number";
  const std::string least = short_number(parameter.least), most = short_number(parameter.most);
  if (!std::isfinite(parameter.most)) return "> " + least;
  return parameter.has_ends ? "from " + least + " to " + most : "between " + least + " and " + most;
}

}  // namespace tagcal::internal
