#pragma once

#include "commands/commands.hpp"

namespace tagcal::tools {

Command add_chart(CLI::App& app);
Command add_stability(CLI::App& app);

}  // namespace tagcal::tools
