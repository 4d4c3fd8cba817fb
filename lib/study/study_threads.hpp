#pragma once

#include <functional>

namespace tagcal::study {

// Switches OpenCV's threads off during its lifetime: the clock of the calling thread does not count
// them.
class OneOpenCvThread {
 public:
  OneOpenCvThread();
  ~OneOpenCvThread();
  OneOpenCvThread(const OneOpenCvThread&) = delete;
  OneOpenCvThread& operator=(const OneOpenCvThread&) = delete;

 private:
  int before_;
};

// Calls work(0) .. work(n - 1), each once, in any order; 0 threads: one per core. Calls must not
// throw.
void in_threads(int n, int threads, const std::function<void(int)>& work);

}  // namespace tagcal::study
