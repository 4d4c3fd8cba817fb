#pragma once

#include <string>

#include "commands/commands.hpp"

// `tagcal chart` and `tagcal stability` live in a program of their own beside this one,
// tagcal-study, which links the libraries that they compare with.
namespace tagcal::tools {

// In the table for the help text alone: main() passes the whole command line on.
Command add_study_command(CLI::App& app, const std::string& name, const std::string& description);
bool is_study_command(int argc, char** argv);

// Replaces this process by tagcal-study. Returns only where that is missing: says how to build it,
// exit code 2.
int run_study_program(char** argv);

}  // namespace tagcal::tools
