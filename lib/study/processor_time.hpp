#pragma once

#include <functional>

namespace tagcal::study {

// Microseconds of the calling thread's processor since some moment: what else the machine does does
// not count.
double thread_processor_us();

// What one call of `work` takes; a short one is called often enough to be seen by the clock.
double processor_us(const std::function<void()>& work);

}  // namespace tagcal::study
