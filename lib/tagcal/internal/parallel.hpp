#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace tagcal::internal {

// Number of threads for an option: 0 means one per core.
int threads_of(int asked);

// The same for n short calls: starting a thread takes as long as many of them.
int threads_for_short_calls(std::size_t n, std::size_t asked);

// Is told (done, n) after each call, under a lock.
using CallProgress = std::function<void(int, int)>;

// Calls work(thread, i) once for each i of [0, n), on up to `threads` threads (0: one per core);
// the caller's is thread 0. Calls must not depend on each other; the results then do not depend on
// the number of threads. An exception stops the remaining calls; of several, that of the smallest i
// is thrown in the end.
void dispatch_calls(std::size_t n, int threads, const std::function<void(int, std::size_t)>& work,
                    const CallProgress& progress = {});

// The same for work(i).
template <typename Work>
void parallel_for(std::size_t n, int threads, const Work& work, const CallProgress& progress = {}) {
  dispatch_calls(
      n, threads, [&](int, std::size_t i) { work(i); }, progress);
}

// The same for work(worker, i), on one thread per worker.
template <typename Worker, typename Work>
void parallel_for(std::size_t n, std::vector<Worker>& workers, const Work& work,
                  const CallProgress& progress = {}) {
  const auto call = [&](int thread, std::size_t i) {
    work(workers[static_cast<std::size_t>(thread)], i);
  };
  dispatch_calls(n, static_cast<int>(workers.size()), call, progress);
}

}  // namespace tagcal::internal
