#pragma once

#include <ctime>
#include <utility>

namespace tagcal {

// Processor time of this thread in seconds.
inline double thread_seconds() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Seconds since the last call.
class Lap {
 public:
  double operator()() {
    const double before = std::exchange(last_, thread_seconds());
    return last_ - before;
  }

 private:
  double last_ = thread_seconds();
};

}  // namespace tagcal
