#include "job/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <system_error>
#include <utility>

#include "job/messages.hpp"

namespace tagcal::tools {
namespace {

constexpr std::chrono::milliseconds kBeforeBar{1000};
constexpr std::chrono::milliseconds kBeforeLine{10000};  // in a pipe only long runs say so
constexpr std::chrono::milliseconds kBetweenBars{100};
constexpr std::chrono::milliseconds kBetweenLines{3000};
constexpr int kBarCells = 25;

// Two significant digits, and no exponent: "3.2/s", "0.41/s", "57/s".
std::string rate_text(double per_second) {
  if (per_second >= 10) return fmt::format("{:.0f}/s", per_second);
  return per_second >= 1 ? fmt::format("{:.1f}/s", per_second)
                         : fmt::format("{:.2f}/s", per_second);
}

// On a terminal, instead of what the line has.
void write_over_line(const std::string& text) {
  std::fputs(("\r\033[K" + text).c_str(), message_stream());
  std::fflush(message_stream());
}

}  // namespace

std::string duration_text(double seconds) {
  const auto whole = static_cast<long long>(std::ceil(seconds));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

std::string progress_text(std::string_view label, int done, int total, double seconds) {
  if (total <= 0) return fmt::format("{}: {}", label, duration_text(std::floor(seconds)));
  std::string text = fmt::format("{}: {} of {}", label, done, total);
  if (done <= 0 || !(seconds > 0)) return text;
  const double per_second = done / seconds;
  text += ", " + rate_text(per_second);
  if (done < total) text += fmt::format(", {} left", duration_text((total - done) / per_second));
  return text;
}

Progress::Progress(std::string label, int total) : label_(std::move(label)), total_(total) {
  if (is_quiet()) return;
  try {
    watcher_ = std::jthread([this](const std::stop_token& stop) { watch(stop); });
  } catch (const std::system_error&) {
    // The system starts no more threads: the work goes on without a line of progress.
  }
}

void Progress::watch(const std::stop_token& stop) {
  const bool on_terminal = isatty(STDERR_FILENO) == 1;
  const Stopwatch watch;
  bool shown = false;
  std::unique_lock lock(mutex_);
  for (auto pause = on_terminal ? kBeforeBar : kBeforeLine;;
       pause = on_terminal ? kBetweenBars : kBetweenLines) {
    wake_.wait_for(lock, stop, pause, [] { return false; });
    if (stop.stop_requested()) break;
    show(watch.seconds(), on_terminal);
    shown = true;
  }
  if (shown && on_terminal) write_over_line("");
}

void Progress::show(double seconds, bool on_terminal) const {
  const int done = done_, total = total_;
  std::string text = progress_text(label_, done, total, seconds);
  if (!on_terminal) {
    print_to_stderr("{}\n", text);
    return;
  }
  if (total > 0) {
    const auto cells = static_cast<std::size_t>(done * static_cast<long long>(kBarCells) / total);
    text = fmt::format("[{:<{}}] {}", std::string(cells, '='), kBarCells, text);
  }
  write_over_line(text);
}

}  // namespace tagcal::tools
