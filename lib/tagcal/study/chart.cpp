#include "tagcal/study/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <opencv2/core/version.hpp>
#include <tuple>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/study/chart_study.hpp"
#include "tagcal/study/mrcal_peer.hpp"
#include "tagcal/study/quantile.hpp"

namespace tagcal {
namespace {

constexpr std::string_view kJobNames[] = {"pose", "focal", "project", "calibrate", "corners"};

ChartStudy study_of(ChartJob job, bool quick) {
  switch (job) {
    case ChartJob::pose:
      return pose_study();
    case ChartJob::focal:
      return focal_study();
    case ChartJob::project:
      return project_study();
    case ChartJob::calibrate:
      return calibrate_study(quick);
    case ChartJob::corners:
      return corners_study();
  }
  return {};
}

void check_same_study(const ChartResult& a, const ChartResult& b) {
  const auto need = [](bool same, const char* what) {
    if (!same) throw Error(fmt::format("the parts to merge differ in their {}", what));
  };
  need(a.job == b.job, "job");
  need(a.seed == b.seed, "seed");
  need(a.num_trials == b.num_trials && a.quick == b.quick, "number of trials");
  need(a.methods == b.methods, "methods");
  need(a.panels == b.panels, "panels");
}

void check_all_shards(const std::vector<Shard>& shards) {
  const int count = shards.front().count;
  for (std::size_t i = 0; i < shards.size(); ++i) {
    if (shards[i].count != count) throw Error("the parts to merge differ in the number of shards");
    if (i > 0 && shards[i] == shards[i - 1])
      throw Error(fmt::format("shard {}/{} is there twice", shards[i].index, count));
  }
  for (int i = 1; i <= count; ++i)
    if (std::find(shards.begin(), shards.end(), Shard{i, count}) == shards.end())
      throw Error(fmt::format("shard {}/{} is missing", i, count));
}

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
  return has_mrcal() ? "OpenCV " CV_VERSION ", mrcal" : "OpenCV " CV_VERSION;
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

ChartResult run_chart(ChartJob job, const ChartOptions& options,
                      const std::function<void(int, int)>& progress) {
  ChartResult result = run_study(study_of(job, options.quick), options, progress);
  result.job = kJobNames[static_cast<std::size_t>(job)];
  return result;
}

ChartResult merge_charts(std::span<const ChartResult> parts) {
  if (parts.empty()) throw Error("nothing to merge");
  ChartResult all = parts.front();
  for (const ChartResult& part : parts.subspan(1)) {
    check_same_study(all, part);
    all.shards.insert(all.shards.end(), part.shards.begin(), part.shards.end());
    all.trials.insert(all.trials.end(), part.trials.begin(), part.trials.end());
    for (const std::string& line : part.origin)
      if (std::find(all.origin.begin(), all.origin.end(), line) == all.origin.end())
        all.origin.push_back(line);
  }
  std::sort(all.shards.begin(), all.shards.end(),
            [](const Shard& a, const Shard& b) { return a.index < b.index; });
  check_all_shards(all.shards);
  all.shards = {Shard{}};
  std::stable_sort(
      all.trials.begin(), all.trials.end(), [](const ChartTrial& a, const ChartTrial& b) {
        return std::tie(a.panel, a.trial, a.method) < std::tie(b.panel, b.trial, b.method);
      });
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

}  // namespace tagcal
