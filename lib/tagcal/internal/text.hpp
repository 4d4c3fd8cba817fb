#pragma once

#include <span>
#include <string>

// Numbers and lists for sentences.

namespace tagcal::internal {

std::string percent(double share);                       // "12 %", "more than 1000 %"
std::string listed(std::span<const std::string> names);  // "a, b and c"

}  // namespace tagcal::internal
