#include "tagcal/internal/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

namespace tagcal::internal {

int threads_of(int asked) {
  return asked > 0 ? asked : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

int threads_for_short_calls(std::size_t n, std::size_t asked) {
  constexpr std::size_t kFewestCalls = 50;  // per thread
  return std::clamp(static_cast<int>(n / kFewestCalls), 1, threads_of(static_cast<int>(asked)));
}

void dispatch_calls(std::size_t n, int threads, const std::function<void(int, std::size_t)>& work,
                    const CallProgress& progress) {
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> failed = false;
  std::mutex mutex;  // of what follows
  int done = 0;
  std::size_t first_failure = n;
  std::exception_ptr error;
  const auto loop = [&](int thread) {
    // A call that was taken is made: so the failure of the smallest index is always found.
    while (!failed) {
      const std::size_t i = next++;
      if (i >= n) return;
      try {
        work(thread, i);
        if (!progress) continue;
        const std::scoped_lock lock(mutex);
        progress(++done, static_cast<int>(n));
      } catch (...) {
        const std::scoped_lock lock(mutex);
        failed = true;
        if (i >= first_failure) continue;
        first_failure = i;
        error = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> others;
    const std::size_t all = std::min(static_cast<std::size_t>(threads_of(threads)), n);
    try {
      for (int t = 1; t < static_cast<int>(all); ++t) others.emplace_back(loop, t);
    } catch (const std::system_error&) {
      // The system starts no more threads: those that run do the work.
    }
    loop(0);
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace tagcal::internal
