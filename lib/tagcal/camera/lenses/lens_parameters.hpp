#pragma once

#include <cmath>
#include <string>

#include "tagcal/camera/lens.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {

// The range of a parameter, behind "must be".
inline std::string range_text(const LensParameter& parameter) {
  if (!std::isfinite(parameter.least)) return "a number";
  const std::string least = short_number(parameter.least), most = short_number(parameter.most);
  if (!std::isfinite(parameter.most)) return "> " + least;
  return parameter.has_ends ? "from " + least + " to " + most : "between " + least + " and " + most;
}

// Throws Error unless the value is finite and in the range of the parameter.
inline void check(const LensParameter& parameter, double value) {
  if (parameter.holds(value)) return;
  const std::string name = "lens: " + std::string(parameter.name);
  if (!std::isfinite(value)) throw Error(name + " is not finite");
  throw Error(name + " must be " + range_text(parameter) + ", got " + short_number(value));
}

// Returns the parameters of lens L unchanged, if they are such.
template <typename L>
const typename L::Parameters& checked(const typename L::Parameters& parameters) {
  for (std::size_t i = 0; i < parameters.size(); ++i) check(L::kParameters[i], parameters[i]);
  return parameters;
}

}  // namespace tagcal::internal
