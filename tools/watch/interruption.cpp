#include "watch/interruption.hpp"

#include <poll.h>

#include <algorithm>
#include <cstddef>
#include <iterator>

namespace tagcal::tools {
namespace {

volatile std::sig_atomic_t is_requested = 0;

void request(int) { is_requested = 1; }

}  // namespace

Interruption::Interruption() {
  is_requested = 0;
  struct sigaction action = {};
  action.sa_handler = request;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < std::size(kSignals); ++i) {
    sigaction(kSignals[i], nullptr, &before_[i]);
    if (before_[i].sa_handler != SIG_IGN) sigaction(kSignals[i], &action, nullptr);
  }
}

Interruption::~Interruption() {
  for (std::size_t i = 0; i < std::size(kSignals); ++i)
    sigaction(kSignals[i], &before_[i], nullptr);
}

bool Interruption::requested() { return is_requested != 0; }

void Interruption::sleep(std::chrono::milliseconds time) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kLongest{100};  // a signal may come between look and poll
  const auto end = Clock::now() + time;
  while (!requested() && Clock::now() < end) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
    ::poll(nullptr, 0, static_cast<int>(std::min(left, kLongest).count()));
  }
}

}  // namespace tagcal::tools
