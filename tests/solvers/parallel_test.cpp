#include "tagcal/internal/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <numeric>
#include <string>

#include "expect.hpp"

namespace tagcal {
namespace {
using namespace internal;

TEST(Parallel, MakesEachCallOnceAndCountsThem) {
  constexpr int kThreads = 4;
  std::vector<int> calls(1000), workers(kThreads);
  int last = 0;
  parallel_for(
      calls.size(), workers,
      [&](int& worker, std::size_t i) {
        ++calls[i];
        ++worker;
      },
      [&](int done, int n) {
        EXPECT_EQ(done, last + 1);
        EXPECT_EQ(n, 1000);
        last = done;
      });
  EXPECT_EQ(calls, std::vector<int>(1000, 1));
  EXPECT_EQ(std::accumulate(workers.begin(), workers.end(), 0), 1000);
  EXPECT_EQ(last, 1000);
}

TEST(Parallel, ThrowsTheFailureOfTheSmallestIndex) {
  for (int trial = 0; trial < 200; ++trial) {
    std::atomic<int> calls = 0;
    const auto fail = [&](std::size_t i) {
      ++calls;
      if (i >= 3) throw Error(std::to_string(i));
    };
    EXPECT_ERROR(parallel_for(1000, 4, fail), "3");
    EXPECT_LT(calls, 1000);
  }
}

}  // namespace
}  // namespace tagcal
