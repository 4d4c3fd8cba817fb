#include "report/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

#include "report/messages.hpp"

namespace tagcal::tools {
namespace {

constexpr std::chrono::milliseconds kBeforeFirst{1000};
constexpr std::chrono::milliseconds kBetweenBars{100};
constexpr std::chrono::milliseconds kBetweenLines{3000};
constexpr int kBarCells = 30;

}  // namespace

Progress::Progress(std::string label, int total)
    : label_(std::move(label)),
      total_(total),
      watcher_([this](const std::stop_token& stop) { watch(stop); }) {}

Progress::~Progress() {
  watcher_.request_stop();
  watcher_.join();
}

void Progress::watch(const std::stop_token& stop) {
  const bool on_terminal = isatty(STDERR_FILENO) == 1;
  const Stopwatch watch;
  bool shown = false;
  std::unique_lock lock(mutex_);
  for (auto pause = kBeforeFirst;; pause = on_terminal ? kBetweenBars : kBetweenLines) {
    wake_.wait_for(lock, stop, pause, [] { return false; });
    if (stop.stop_requested()) break;
    show(watch.seconds(), on_terminal);
    shown = true;
  }
  if (shown && on_terminal) print_to_stderr("\r\033[K");  // leave a clean line behind
}

void Progress::show(double seconds, bool on_terminal) const {
  const int done = done_;
  std::string text = fmt::format("{}: {:.0f} s", label_, seconds);
  if (total_ > 0) text = fmt::format("{}: {} of {}, {:.0f} s", label_, done, total_, seconds);
  if (!on_terminal) {
    print_to_stderr("{}\n", text);
    return;
  }
  if (total_ > 0) {
    const int cells = done * kBarCells / total_;
    text = fmt::format("[{:<{}}] {}", std::string(cells, '='), kBarCells, text);
  }
  print_to_stderr("\r\033[K{}", text);
  std::fflush(stderr);
}

}  // namespace tagcal::tools
