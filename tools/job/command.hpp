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
  bool only_writes = false;  // no result on stdout: --json says what was written
};

}  // namespace tagcal::tools
