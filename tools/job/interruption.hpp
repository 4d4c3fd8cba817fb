#pragma once

#include <chrono>
#include <filesystem>
#include <system_error>

// What SIGINT (Ctrl-C), SIGTERM and SIGHUP do: they end the command, after its temporary files and
// folders are removed. Signals that the caller ignores (nohup) stay ignored. SIGPIPE and SIGXFSZ
// become errors of writing.

namespace tagcal::tools {

// Takes over the signals: from now on a thread of its own waits for them. Call it before any other
// thread is started.
void end_tidily_on_signals();

// While it lives, the first signal only asks the command to end, the second one ends it. One at a
// time.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  static bool requested();

  // Returns early if a signal comes.
  static void sleep(std::chrono::milliseconds time);
};

// A new folder. While this lives, a signal that ends the command removes the folder.
class RemovedOnSignal {
 public:
  // `why` says why the folder could not be created, also if there is one already.
  RemovedOnSignal(std::filesystem::path folder, std::error_code& why);
  ~RemovedOnSignal();
  RemovedOnSignal(const RemovedOnSignal&) = delete;
  RemovedOnSignal& operator=(const RemovedOnSignal&) = delete;

 private:
  std::filesystem::path folder_;
};

}  // namespace tagcal::tools
