#pragma once

#include <functional>
#include <vector>

#include "commands/commands.hpp"

namespace tagcal::tools {

// Adds its commands to an application that has none yet.
using CommandTable = std::function<std::vector<Command>(CLI::App&)>;

// Reads a command line, runs the command that it names, and returns the exit code. The only place
// where errors end: each becomes one line on stderr.
int run_command_line(int argc, char** argv, const CommandTable& table);

}  // namespace tagcal::tools
