#include "study/peers/quiet_stderr.hpp"

#include <cstdio>
#include <mutex>

namespace tagcal::study {
namespace {

std::mutex mutex;
int count = 0;  // of those that exist
FILE* usual = nullptr;

// Never closed: a thread of another library may still hold it.
FILE* nowhere() {
  static FILE* const stream = std::fopen("/dev/null", "w");
  return stream;
}

}  // namespace

// In the GNU C library stderr is a variable that may be set ("Standard Streams" in its manual).
QuietStderr::QuietStderr() {
  const std::lock_guard lock(mutex);
  if (count++ > 0 || !nowhere()) return;
  usual = stderr;
  stderr = nowhere();
}

QuietStderr::~QuietStderr() {
  const std::lock_guard lock(mutex);
  if (--count > 0 || !usual) return;
  stderr = usual;
  usual = nullptr;
}

}  // namespace tagcal::study
