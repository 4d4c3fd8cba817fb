#pragma once

#include "commands/reproject_run.hpp"

namespace tagcal::tools {

// `tagcal reproject LEFT RIGHT --camera RIG --rectify DIR`. Returns the exit code. Throws Error.
int run_rectify(const ReprojectArguments& arguments);

}  // namespace tagcal::tools
