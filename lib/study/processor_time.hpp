#pragma once

#include <functional>
#include <utility>

namespace tagcal::study {

// Processor time of the calling thread in microseconds since an arbitrary moment; other load of the
// machine does not count.
double thread_processor_us();

// The processor time of one call of `work`; short work is repeated until the clock resolves it.
double processor_us(const std::function<void()>& work);

// Seconds of processor time of this thread since the last call.
class Lap {
 public:
  double operator()() {
    const double before = std::exchange(last_us_, thread_processor_us());
    return 1e-6 * (last_us_ - before);
  }

 private:
  double last_us_ = thread_processor_us();
};

}  // namespace tagcal::study
