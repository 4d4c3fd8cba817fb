#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

namespace tagcal::tools {

// "detecting: 12 of 200, 3.2/s, 59 s left": the rate and the time left are means since the start.
// With a `total` of 0 the time alone: "calibrating: 4 s".
std::string progress_text(std::string_view label, int done, int total, double seconds);

// "59 s", "2 min 5 s", "1 h 10 min".
std::string duration_text(double seconds);

// Prints the progress of a job on stderr, unless --quiet: a bar on a terminal after the first
// second, a line every few seconds if stderr is piped, after the first ten. With a `total` of 0 it
// prints the time only.
class Progress {
 public:
  explicit Progress(std::string label, int total = 0);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(int done) { done_ = done; }
  void update(int done, int total) {
    total_ = total;
    done_ = done;
  }

 private:
  void watch(const std::stop_token& stop);
  void show(double seconds, bool on_terminal) const;

  std::string label_;
  std::atomic<int> total_;
  std::atomic<int> done_ = 0;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread watcher_;  // last: its thread uses the members above
};

// Wall-clock seconds since its construction.
class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace tagcal::tools
