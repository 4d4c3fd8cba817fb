#include "input/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace tagcal::tools {
namespace {

class Pool {
 public:
  Pool(int count, const std::function<void(int)>& work, const std::function<void(int)>& done)
      : work_(work), done_(done), failures_(count) {}

  void run(int threads) {
    {
      std::vector<std::jthread> workers;
      for (int i = 0; i < threads; ++i) workers.emplace_back([this] { drain(); });
    }
    for (const std::exception_ptr& failure : failures_) {
      if (failure) std::rethrow_exception(failure);
    }
  }

 private:
  void drain() {
    for (int i = next_++; i < static_cast<int>(failures_.size()) && !failed_; i = next_++) {
      try {
        work_(i);
      } catch (...) {  // carried over to the caller's thread
        failures_[i] = std::current_exception();
        failed_ = true;
        return;
      }
      const std::lock_guard lock(mutex_);
      done_(++num_done_);
    }
  }

  const std::function<void(int)>& work_;
  const std::function<void(int)>& done_;
  std::vector<std::exception_ptr> failures_;
  std::atomic<int> next_ = 0;
  std::atomic<bool> failed_ = false;
  std::mutex mutex_;
  int num_done_ = 0;
};

}  // namespace

void for_each_parallel(int count, int threads, const std::function<void(int)>& work,
                       const std::function<void(int)>& done) {
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  Pool(count, work, done).run(std::clamp(threads == 0 ? cores : threads, 1, std::max(1, count)));
}

}  // namespace tagcal::tools
