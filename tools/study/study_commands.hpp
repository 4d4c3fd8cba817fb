#pragma once

#include "job/command.hpp"

namespace tagcal::tools {

Command add_chart(CLI::App& app);
Command add_stability(CLI::App& app);

}  // namespace tagcal::tools
