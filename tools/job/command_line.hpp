#pragma once

#include <functional>
#include <string>
#include <vector>

#include "job/command.hpp"

namespace tagcal::tools {

// Adds all commands to an application.
using CommandTable = std::function<std::vector<Command>(CLI::App&)>;

// What --help and the program alone print.
struct ProgramText {
  std::string description;
  std::string guide;  // printed without arguments; "": an error
  std::string examples;
};

// "help COMMAND" becomes "COMMAND --help".
void read_help_word(int argc, char** argv);

// Parses a command line, runs its command, and returns the exit code. This is the only place that
// catches errors: each becomes one line on stderr.
int run_command_line(int argc, char** argv, const CommandTable& table, const ProgramText& program);

// The arguments of the program as a shell would read them: "tagcal report camera.yaml ..".
const std::string& command_as_typed();

}  // namespace tagcal::tools
