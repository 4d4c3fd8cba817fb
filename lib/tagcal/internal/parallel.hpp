#pragma once

#include <algorithm>
#include <cstddef>
#include <thread>
#include <vector>

namespace tagcal::internal {

// Calls work(i) for each i of [0, n), on several threads if there are enough calls; 0 threads: one
// per core. Calls must not depend on each other, nor throw. Results then do not depend on the
// number of threads.
template <typename Work>
void parallel_for(std::size_t n, std::size_t num_threads, const Work& work) {
  constexpr std::size_t kFewestCalls = 50;  // per thread
  if (num_threads == 0) num_threads = std::max(1u, std::thread::hardware_concurrency());
  num_threads = std::clamp<std::size_t>(n / kFewestCalls, 1, num_threads);
  const auto part = [&](std::size_t t) {
    for (std::size_t i = t * n / num_threads; i < (t + 1) * n / num_threads; ++i) work(i);
  };
  std::vector<std::jthread> threads;
  for (std::size_t t = 1; t < num_threads; ++t) threads.emplace_back(part, t);
  part(0);
}

}  // namespace tagcal::internal
