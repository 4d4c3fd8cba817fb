// Counts how often calibrations refuse the focal length of data sets that do not determine it, and
// answer for those that do (docs/trust/how_sure.md).
// Sets that may be answered take a fifth of the seeds. `beyond 5 sd`: an answer whose focal length
// is off by more than 5 standard deviations; `warned of`: a finding gives a reason for it.

#include <algorithm>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "studies/studies.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/findings.hpp"
#include "worlds.hpp"

namespace tagcal {
using namespace study;
namespace {

WorldOptions tilted(int num_views, double min_tilt_deg, double max_tilt_deg) {
  WorldOptions options;
  options.num_views = num_views;
  options.min_tilt_deg = min_tilt_deg;
  options.max_tilt_deg = max_tilt_deg;
  return options;
}

Dataset pinhole_views(const WorldOptions& options, std::uint64_t seed) {
  return make_world(pinhole(900, 900, 639.5, 399.5), seed, options);
}

Dataset long_lens(std::uint64_t seed) {
  WorldOptions options;
  options.num_views = 5;
  options.min_distance_m = 400;
  options.max_distance_m = 420;
  return make_world(pinhole(300'000, 300'000, 639.5, 399.5), seed, options);
}

// Views of one rotation, shifted at random by up to `shift_m` a coordinate, with fresh noise each.
Dataset parallel_views(const Lens& lens, std::uint64_t seed, int num_views, double shift_m) {
  const WorldOptions options = tilted(1, 30, 30);
  Dataset set = make_world(lens, seed, options);
  const Pose first = set.truth->camera_from_world.at("0.png");
  const auto points = target_points(set.boards[0].board);
  Random random(seed, 77);
  set.views.clear();
  for (int i = 0; i < num_views; ++i) {
    const Eigen::Vector3d shift(random.uniform(-1, 1), random.uniform(-1, 1),
                                random.uniform(-1, 1));
    const Pose pose(first.rotation(), first.translation() + shift_m * shift);
    View view = observe(set.truth->camera, pose, points, options, random);
    view.image = std::to_string(i) + ".png";
    set.truth->camera_from_world[view.image] = pose;
    set.views.push_back(view);
  }
  return set;
}

struct RefusedSet {
  const char* name;
  bool all_seeds;
  std::function<Dataset(std::uint64_t)> make;
};

const std::vector<RefusedSet>& sets() {
  static const Lens centred = pinhole(900, 900, 639.5, 399.5), beside = pinhole(900, 900, 659, 415);
  static const std::vector<RefusedSet> all = {
      {"10 frontal", true, [](auto seed) { return pinhole_views(tilted(10, 0, 0), seed); }},
      {"1 frontal", true, [](auto seed) { return pinhole_views(tilted(1, 0, 0), seed); }},
      {"300,000 px at 400 m", true, [](auto seed) { return long_lens(seed); }},
      {"10 frontal, distorted", false,
       [](auto seed) { return make_world(opencv5_lens(), seed, tilted(10, 0, 0)); }},
      {"3 at 2 degrees", false, [](auto seed) { return pinhole_views(tilted(3, 2, 2), seed); }},
      {"1 at 30-50", false, [](auto seed) { return pinhole_views(tilted(1, 30, 50), seed); }},
      {"10 of one pose at 30", false,
       [](auto seed) { return parallel_views(centred, seed, 10, 0); }},
      {"10 parallel at 30", false,
       [](auto seed) { return parallel_views(centred, seed, 10, 0.2); }},
      {"10 parallel, centre off", false,
       [](auto seed) { return parallel_views(beside, seed, 10, 0.2); }},
      {"2 parallel at 30", false, [](auto seed) { return parallel_views(centred, seed, 2, 0.2); }},
      {"2 at 20-50", false, [](auto seed) { return pinhole_views(tilted(2, 20, 50), seed); }},
      {"5 at 0-50", false, [](auto seed) { return pinhole_views(tilted(5, 0, 50), seed); }},
      {"5 at 0-50, opencv5", false,
       [](auto seed) { return make_world(opencv5_lens(), seed, tilted(5, 0, 50)); }}};
  return all;
}

// True if the finding says that the principal point is assumed or that the model is too small.
bool explains_bias(const Finding& finding) {
  constexpr std::array kCodes = {
      code::principal_point_untested, code::model_too_small, code::other_lens,
      code::residuals_biased,         code::halves_disagree, code::board_bend_impossible};
  return std::ranges::find(kCodes, finding.code, &FindingCode::name) != kCodes.end();
}

std::string answer(const Dataset& set, const std::string& model) {
  CalibrateOptions options;
  options.model = model;
  const Calibration c = calibrate(set, options);
  std::string what = (model == "auto" ? c.model + " " : "") + std::string(status_name(c.status));
  if (!is_answer(c.status)) return what;
  const double truth = parameters(set.truth->camera.lens)[0];
  const double error = std::abs(parameters(c.camera->lens)[0] - truth) / c.sigmas[0];
  if (error <= 5) return what;
  if (std::ranges::any_of(c.findings, explains_bias)) return what + " beyond 5 sd, warned of";
  return what + " beyond 5 sd";
}

std::vector<Task> focal_refusal_tasks(const StudyOptions& options) {
  std::vector<Task> tasks;
  for (const std::string model : {"auto", "f", "f+c", "opencv5", "fisheye4", "opencv8"})
    for (const RefusedSet& set : sets())
      tasks.push_back({model + ": " + set.name,
                       [&set, model](std::uint64_t seed) -> std::vector<Values> {
                         return {{answer(set.make(seed), model)}};
                       },
                       set.all_seeds ? options.count : std::max(1, options.count / 5)});
  return tasks;
}

}  // namespace

Study focal_refusal_study() {
  return {.name = "focal_refusal",
          .summary = "data that determine the focal length and data that do not: who is answered",
          .count = 1000,
          .columns = {"answer"},
          .tasks = focal_refusal_tasks,
          .tables = {{{"task"}, {rows_in("sets"), counts_of("answers", "answer")}}}};
}

}  // namespace tagcal
