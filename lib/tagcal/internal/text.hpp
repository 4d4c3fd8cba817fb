#pragma once

#include <span>
#include <string>

// Numbers and lists in sentences.

namespace tagcal::internal {

std::string percent(double share);                       // "12 %"
std::string listed(std::span<const std::string> names);  // "a, b and c"

}  // namespace tagcal::internal
