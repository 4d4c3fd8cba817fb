#pragma once

#include <CLI/App.hpp>
#include <functional>

namespace tagcal::tools {

// What the shell sees (README: exit codes).
enum ExitCode : int { kAnswer = 0, kCheckFailed = 1, kBadInput = 2, kNoAnswer = 3 };

// A command of the table in tagcal.cpp: its arguments, and what it does once they are read. `run`
// throws Error for bad input and prints results to stdout, everything else to stderr.
struct Command {
  CLI::App* arguments = nullptr;
  std::function<int()> run;
};

Command add_render(CLI::App& app);
Command add_detect(CLI::App& app);
Command add_calibrate(CLI::App& app);
Command add_validate(CLI::App& app);
Command add_pose(CLI::App& app);
Command add_board(CLI::App& app);
Command add_view(CLI::App& app);
Command add_diff(CLI::App& app);

}  // namespace tagcal::tools
