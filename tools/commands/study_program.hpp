#pragma once

#include <vector>

#include "job/command.hpp"

// `tagcal chart` and `tagcal stability` live in a program of their own beside this one,
// tagcal-study, which links the libraries that they compare with.
namespace tagcal::tools {

// Adds its commands to the table for the help text only: main() passes the command line on.
void add_study_commands(CLI::App& app, std::vector<Command>& commands);
bool is_study_command(int argc, char** argv);

// Replaces this process by tagcal-study. If that program is missing, prints how to build it and
// returns exit code 2.
int run_study_program(char** argv);

}  // namespace tagcal::tools
