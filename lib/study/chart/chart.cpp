#include "study/chart/chart.hpp"

#include <fmt/format.h>

#include <ceres/version.h>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <opencv2/core/version.hpp>
#include <utility>

#include "study/peers/mrcal_peer.hpp"
#include "study/peers/pose_peers.hpp"
#include "study/quantile.hpp"

namespace tagcal::study {
namespace {

constexpr std::string_view kJobNames[] = {"pose",    "focal", "project", "calibrate",
                                          "corners", "rig",   "handeye"};

double root_mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));  // of none: NaN
}

Spread spread_of(const std::vector<double>& values) {
  return {quantile(values, 0.5), quantile(values, 0.05), quantile(values, 0.95)};
}

ChartPoint point_of(int panel, int method, const std::vector<const ChartTrial*>& trials) {
  ChartPoint point{panel, method};
  std::vector<double> times, errors, over_bound;
  for (const ChartTrial* trial : trials) {
    times.push_back(trial->time_us);
    ++point.trials;
    point.failures += trial->failed;
    if (trial->failed) continue;
    errors.push_back(trial->error);
    over_bound.push_back(trial->over_bound);
  }
  point.time_us = spread_of(times);
  point.rms = root_mean_square(errors);
  point.rms_over_bound = root_mean_square(over_bound);
  point.over_bound = spread_of(over_bound);
  return point;
}

}  // namespace

std::span<const std::string_view> chart_job_names() { return kJobNames; }

std::optional<ChartJob> chart_job(std::string_view name) {
  const auto found = std::find(std::begin(kJobNames), std::end(kJobNames), name);
  if (found == std::end(kJobNames)) return std::nullopt;
  return static_cast<ChartJob>(found - std::begin(kJobNames));
}

std::string peers_versions() {
  std::string versions = "OpenCV " CV_VERSION ", Ceres " CERES_VERSION_STRING;
  if (has_mrcal()) versions += ", mrcal";
  if (!opengv_poses().empty()) versions += ", OpenGV";
  return versions;
}

std::string ChartPanel::name() const {
  std::string all;
  for (const std::string& title : {page, row, column}) {
    if (title.empty()) continue;
    if (!all.empty()) all += ", ";
    all += title;
  }
  return all;
}

std::vector<ChartPoint> chart_points(const ChartResult& result) {
  std::map<std::pair<int, int>, std::vector<const ChartTrial*>> by_point;
  for (const ChartTrial& trial : result.trials)
    by_point[{trial.panel, trial.method}].push_back(&trial);
  std::vector<ChartPoint> points;
  for (const auto& [key, trials] : by_point)
    points.push_back(point_of(key.first, key.second, trials));
  return points;
}

}  // namespace tagcal::study
