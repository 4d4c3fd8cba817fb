#pragma once

#include <functional>
#include <string>
#include <vector>

#include "job/command.hpp"

namespace tagcal::tools {

// Adds all commands to an application.
using CommandTable = std::function<std::vector<Command>(CLI::App&)>;

// Parses a command line, runs its command, and returns the exit code. This is the only place that
// catches errors: each becomes one line on stderr.
int run_command_line(int argc, char** argv, const CommandTable& table);

// The arguments of the program as a shell would read them: "tagcal report camera.yaml ..".
const std::string& command_as_typed();

}  // namespace tagcal::tools
