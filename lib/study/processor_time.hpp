#pragma once

#include <functional>

namespace tagcal::study {

// Processor time of the calling thread in microseconds since an arbitrary moment; other load of the
// machine does not count.
double thread_processor_us();

// The processor time of one call of `work`; short work is repeated until the clock resolves it.
double processor_us(const std::function<void()>& work);

}  // namespace tagcal::study
