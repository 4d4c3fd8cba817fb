#pragma once

#include <string>

namespace tagcal::tools {

// The processor's name, or "unknown processor".
std::string processor_name();

// Today (UTC), as 2026-01-31.
std::string today();

}  // namespace tagcal::tools
