#pragma once

namespace tagcal::study {

// While one exists, other libraries' messages to the C stream stderr are dropped, in all threads:
// AprilTag's estimate_tag_pose and glog print there, and have no option or start-up that stops all
// of it. A message of our own must be written to a stream that was kept from before. Private to
// study.
class QuietStderr {
 public:
  QuietStderr();
  ~QuietStderr();
  QuietStderr(const QuietStderr&) = delete;
  QuietStderr& operator=(const QuietStderr&) = delete;
};

}  // namespace tagcal::study
