#include "study/study_threads.hpp"

#include <algorithm>
#include <atomic>
#include <opencv2/core/utility.hpp>
#include <thread>
#include <vector>

namespace tagcal::study {

OneOpenCvThread::OneOpenCvThread() : before_(cv::getNumThreads()) { cv::setNumThreads(1); }

OneOpenCvThread::~OneOpenCvThread() { cv::setNumThreads(before_); }

void in_threads(int n, int threads, const std::function<void(int)>& work) {
  std::atomic<int> next = 0;
  const auto drain = [&] {
    for (int i = next++; i < n; i = next++) work(i);
  };
  if (threads == 0) threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  std::vector<std::jthread> others;
  for (int i = 1; i < std::min(threads, n); ++i) others.emplace_back(drain);
  drain();
}

}  // namespace tagcal::study
