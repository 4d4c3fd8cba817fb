#pragma once

#include <cmath>
#include <string>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {

// Returns the parameters of lens L unchanged. Throws Error unless all are finite and the scales >
// 0.
template <typename L>
const typename L::Parameters& checked(const typename L::Parameters& parameters) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const std::string name(L::kParameterNames[i]);
    if (!std::isfinite(parameters[i])) throw Error("lens: " + name + " is not finite");
    if (i < 2 && !(parameters[i] > 0))
      throw Error("lens: " + name + " must be > 0, got " + short_number(parameters[i]));
  }
  return parameters;
}

}  // namespace tagcal::internal
