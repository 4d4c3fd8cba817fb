// Measures the memory and the time of calibrate() with many views (docs/trust/reliability.md).
//   big_data [MODEL, default auto [THREADS, default 1 [VIEWS, default 1000 and 10000]..]]
// The environment variable OUTLIERS is the share of wrong corners, default 0. A board of 36 tags
// from all sides, about 140 corners a view, each with its covariance, as detect() gives them.
// Memory is the largest resident size during the call less that before it, per corner; `input` is
// that of the data set itself. Linux only (/proc/self).

#include <malloc.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "tagcal/estimate/calibrate.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

// A line of /proc/self/status, in bytes.
double status_bytes(const std::string& key) {
  std::ifstream file("/proc/self/status");
  for (std::string word; file >> word;) {
    if (word != key) continue;
    double kilobytes = 0;
    file >> kilobytes;
    return 1024 * kilobytes;
  }
  return 0;
}

// The largest resident size is counted anew from here on.
void forget_peak() { std::ofstream("/proc/self/clear_refs") << 5; }

Dataset big_dataset(int num_views) {
  WorldOptions options;
  options.num_views = num_views;
  options.sigma_px = 0.1;
  if (const char* const share = std::getenv("OUTLIERS")) options.outlier_share = std::atof(share);
  Dataset dataset = make_world(opencv5_lens(), 23, options);
  for (View& view : dataset.views) {
    for (Observation& seen : view.observations)
      seen.covariance_px2 = Matrix2(0.01 * Eigen::Matrix2d::Identity());
    view.observations.shrink_to_fit();
  }
  return dataset;
}

void measure(const CalibrateOptions& options, int num_views) {
  malloc_trim(0);
  const double at_start = status_bytes("VmRSS:");
  const Dataset dataset = big_dataset(num_views);
  std::size_t corners = 0;
  for (const View& view : dataset.views) corners += view.observations.size();
  malloc_trim(0);
  const double before = status_bytes("VmRSS:");
  forget_peak();
  const auto begin = std::chrono::steady_clock::now();
  const Calibration c = calibrate(dataset, options);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const double peak = status_bytes("VmHWM:"), n = static_cast<double>(corners);
  std::printf("| %d | %zu | %.0f | %.0f | %.1f | %.1f | %s %s | %.4f |\n", num_views, corners,
              (before - at_start) / n, (peak - before) / n, seconds, 1e6 * seconds / n,
              std::string(status_name(c.status)).c_str(), c.model.c_str(),
              c.sigmas.empty() ? 0.0 : c.sigmas[0]);
  std::fflush(stdout);
}

}  // namespace
}  // namespace tagcal

int main(int argc, char** argv) {
  tagcal::CalibrateOptions options;
  if (argc > 1) options.model = argv[1];
  if (argc > 2) options.num_threads = static_cast<std::size_t>(std::atoi(argv[2]));
  std::vector<int> views;
  for (int i = 3; i < argc; ++i) views.push_back(std::atoi(argv[i]));
  if (views.empty()) views = {1000, 10000};
  std::printf(
      "| views | corners | input, bytes a corner | beyond it, bytes a corner | time, s | us a "
      "corner "
      "| answer | sd of fx, px |\n|---|---|---|---|---|---|---|---|\n");
  for (const int num_views : views) tagcal::measure(options, num_views);
}
