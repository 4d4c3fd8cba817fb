#pragma once

#include <functional>

namespace tagcal::study {

// OpenCV's own threads would not be seen by the clock of the calling one: none while this lives.
class OneOpenCvThread {
 public:
  OneOpenCvThread();
  ~OneOpenCvThread();
  OneOpenCvThread(const OneOpenCvThread&) = delete;
  OneOpenCvThread& operator=(const OneOpenCvThread&) = delete;

 private:
  int before_;
};

// Calls work(0) .. work(n - 1), each once, in any order; 0 threads: one a core. Calls must not
// throw.
void in_threads(int n, int threads, const std::function<void(int)>& work);

}  // namespace tagcal::study
