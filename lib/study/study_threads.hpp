#pragma once

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

}  // namespace tagcal::study
