#pragma once

#include <chrono>
#include <csignal>

namespace tagcal::tools {

// While it lives, the first SIGINT (Ctrl-C), SIGTERM or SIGHUP asks the command to end, the second
// one ends it at once. Signals that the caller ignores (nohup) stay ignored. One at a time.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  static bool requested();

  // Returns early if a signal comes.
  static void sleep(std::chrono::milliseconds time);

 private:
  static constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};
  struct sigaction before_[3] = {};
};

}  // namespace tagcal::tools
