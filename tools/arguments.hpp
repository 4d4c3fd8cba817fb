#pragma once

#include <CLI/App.hpp>
#include <limits>
#include <string>

namespace tagcal::tools {

// Options with a number, checked where they enter, with messages that say what must hold
// (CLI11's own print the bounds in full, 309 digits of them).
CLI::Option* add_integer(CLI::App& command, const std::string& name, int& value, int minimum,
                         const std::string& help);
CLI::Option* add_positive(CLI::App& command, const std::string& name, double& value,
                          const std::string& help);

// --threads: 0 asks for one per core.
CLI::Option* add_threads(CLI::App& command, int& threads);

}  // namespace tagcal::tools
