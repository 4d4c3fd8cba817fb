#pragma once

#include <CLI/App.hpp>
#include <cstdint>
#include <string>
#include <vector>

// The options library, compiled once: what is called through these functions is not compiled again
// with every command.
namespace tagcal::tools {

CLI::App* add_command(CLI::App& app, const std::string& name, const std::string& description);
CLI::Option* add_option(CLI::App& command, const std::string& name, std::string& value,
                        const std::string& help);
CLI::Option* add_option(CLI::App& command, const std::string& name,
                        std::vector<std::string>& values, const std::string& help);
CLI::Option* add_option(CLI::App& command, const std::string& name, std::uint64_t& value,
                        const std::string& help);
CLI::Option* add_flag(CLI::App& command, const std::string& name, bool& value,
                      const std::string& help);

// Options with a number, checked where they enter, with messages that say what must hold
// (CLI11's own print the bounds in full, 309 digits of them).
CLI::Option* add_integer(CLI::App& command, const std::string& name, int& value, int minimum,
                         const std::string& help);
CLI::Option* add_positive(CLI::App& command, const std::string& name, double& value,
                          const std::string& help);

// --threads: 0 asks for one per core.
CLI::Option* add_threads(CLI::App& command, int& threads);

}  // namespace tagcal::tools
