#pragma once

#include <string>
#include <vector>

namespace tagcal::tools {

// How a chart or a map was made: the command, the versions, the processor and the day.
std::vector<std::string> origin_of(const std::string& command);

}  // namespace tagcal::tools
