#include "study/processor_time.hpp"

#include <algorithm>
#include <ctime>

namespace tagcal::study {

double thread_processor_us() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

double processor_us(const std::function<void()>& work) {
  constexpr double kLongEnoughUs = 60;  // a hundred times what the clock itself takes
  double begin = thread_processor_us();
  work();
  const double once = thread_processor_us() - begin;
  if (once >= kLongEnoughUs) return once;
  const int repeats = static_cast<int>(kLongEnoughUs / std::max(once, 0.5)) + 1;
  begin = thread_processor_us();
  for (int i = 0; i < repeats; ++i) work();
  return (thread_processor_us() - begin) / repeats;
}

}  // namespace tagcal::study
