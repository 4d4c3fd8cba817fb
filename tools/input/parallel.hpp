#pragma once

#include <functional>

namespace tagcal::tools {

// Runs work(0) .. work(count - 1) on a pool of `threads` workers (0: one per core), in any order.
// The first failure (by index) stops the rest and is thrown here. `done(n)` is called under a lock.
void for_each_parallel(int count, int threads, const std::function<void(int)>& work,
                       const std::function<void(int)>& done);

}  // namespace tagcal::tools
