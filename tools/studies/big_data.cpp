// Measures the memory and the time of calibrate() with many views (docs/trust/reliability.md). A
// board of 36 tags from all sides, about 140 corners a view, each with its covariance, as detect()
// gives them. Memory is the largest resident size during the call less that before it, per corner;
// `input` is that of the data set itself. Linux only (/proc/self).

#include <fmt/format.h>
#include <malloc.h>

#include <chrono>
#include <fstream>
#include <string>

#include "studies/studies.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "worlds.hpp"

namespace tagcal {
using namespace study;
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

Dataset big_dataset(int num_views, double outlier_share) {
  WorldOptions options;
  options.num_views = num_views;
  options.sigma_px = 0.1;
  options.outlier_share = outlier_share;
  Dataset dataset = make_world(opencv5_lens(), 23, options);
  for (View& view : dataset.views) {
    for (Observation& seen : view.observations)
      seen.covariance_px2 = Matrix2(0.01 * Eigen::Matrix2d::Identity());
    view.observations.shrink_to_fit();
  }
  return dataset;
}

std::vector<Values> measure(const CalibrateOptions& options, int num_views, double outlier_share) {
  malloc_trim(0);
  const double at_start = status_bytes("VmRSS:");
  const Dataset dataset = big_dataset(num_views, outlier_share);
  double corners = 0;
  for (const View& view : dataset.views) corners += static_cast<double>(view.observations.size());
  malloc_trim(0);
  const double before = status_bytes("VmRSS:");
  forget_peak();
  const auto begin = std::chrono::steady_clock::now();
  const Calibration c = calibrate(dataset, options);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const double peak = status_bytes("VmHWM:");
  return {{corners, (before - at_start) / corners, (peak - before) / corners, seconds,
           1e6 * seconds / corners, fmt::format("{} {}", status_name(c.status), c.model),
           c.sigmas.empty() ? 0.0 : c.sigmas[0]}};
}

std::vector<Task> big_data_tasks(const StudyOptions& options) {
  CalibrateOptions calibrate;
  calibrate.model = options.text("model");
  const double outlier_share = options.number("outliers");
  std::vector<Task> tasks;
  for (const std::string& views : options.inputs) {
    const int n = std::atoi(views.c_str());
    if (n < 1) throw Error(views + ": must be a number of views");
    tasks.push_back({views, [=](std::uint64_t) { return measure(calibrate, n, outlier_share); }});
  }
  return tasks;
}

}  // namespace

Study big_data_study() {
  return {.name = "big_data",
          .summary = "memory and time of a calibration of many views",
          .inputs = "numbers of views",
          .count = 1,
          .options = {{"model", "auto", "of the calibration"},
                      {"outliers", "0", "share of wrong corners"}},
          .columns = {"corners", "input", "beyond", "seconds", "us", "answer", "sd_fx"},
          .tasks = big_data_tasks,
          .tables = {{{"task"},
                      {sum_of("corners", "corners"), sum_of("input, bytes a corner", "input"),
                       sum_of("beyond it, bytes a corner", "beyond"),
                       sum_of("time, s", "seconds", 1), sum_of("us a corner", "us", 1),
                       counts_of("answer", "answer"), sum_of("sd of fx, px", "sd_fx", 4)}}}};
}

}  // namespace tagcal
