#pragma once

#include <functional>

namespace CLI {
class App;
}  // namespace CLI

namespace tagcal::tools {

// Exit codes of the program (README).
enum ExitCode : int { kAnswer = 0, kCheckFailed = 1, kBadInput = 2, kNoAnswer = 3 };

// A command of the table in tagcal.cpp: its arguments, and the function to call after parsing.
// `run` throws Error for bad input and prints results to stdout, everything else to stderr.
struct Command {
  CLI::App* arguments = nullptr;
  std::function<int()> run;
};

Command add_render(CLI::App& app);
Command add_detect(CLI::App& app);
Command add_calibrate(CLI::App& app);
Command add_watch(CLI::App& app);
Command add_validate(CLI::App& app);
Command add_report(CLI::App& app);
Command add_pose(CLI::App& app);
Command add_board(CLI::App& app);
Command add_view(CLI::App& app);
Command add_diff(CLI::App& app);
Command add_convert(CLI::App& app);
Command add_reproject(CLI::App& app);
Command add_project(CLI::App& app);
Command add_unproject(CLI::App& app);
Command add_completion(CLI::App& app);

}  // namespace tagcal::tools
