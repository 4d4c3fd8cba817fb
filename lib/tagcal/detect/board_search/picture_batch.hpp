#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "tagcal/detect/types.hpp"

// Private to detect.
namespace tagcal::internal {

// Number of threads for an option: 0 means one per core.
inline int threads_of(int asked) {
  return asked > 0 ? asked : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

// Calls work(worker, i) once for each picture i of [0, n), on one thread per worker (one or more);
// the first worker runs on the caller's thread. An exception stops the remaining pictures; of
// several, that of the first picture is thrown in the end. `progress(done, n)` is called under a
// lock.
template <typename Workers, typename Work>
void for_each_picture(std::size_t n, Workers& workers, const Work& work,
                      const std::function<void(int, int)>& progress) {
  std::vector<std::exception_ptr> errors(n);
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> failed = false;
  std::mutex mutex;
  int done = 0;
  const auto loop = [&](auto& worker) {
    for (std::size_t i = next++; i < n && !failed; i = next++) {
      try {
        work(worker, i);
        const std::scoped_lock lock(mutex);
        if (progress) progress(++done, static_cast<int>(n));
      } catch (...) {
        errors[i] = std::current_exception();
        failed = true;
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 1; t < workers.size(); ++t)
      threads.emplace_back([&loop, &worker = workers[t]] { loop(worker); });
    loop(workers[0]);
  }
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

}  // namespace tagcal::internal
