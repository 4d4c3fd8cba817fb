// The choice of frames of a clip (estimate/frame_choice.hpp) beside all of its frames and beside
// every Nth of equal count. An input is a scene; each trial adds fresh noise to its exact corners.
// sd: of the projection at infinity as the calibration claims it, px per coordinate, RMS over the
// whole image; error: the same of the difference from the true lens. cpu: processor time of one
// thread for the calibration, of the choice with all that it computes. Ratios are of the means.

#include <cmath>
#include <memory>
#include <numeric>

#include "studies/studies.hpp"
#include "study/processor_time.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/frame_choice.hpp"
#include "tagcal/internal/spread_indices.hpp"
#include "tagcal/io/scene_file.hpp"
#include "tagcal/random.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"

namespace tagcal {
using namespace study;
namespace {

// The corners of a clip in a trial, and the true camera.
Dataset noisy(const Dataset& exact, double sigma_px, std::uint64_t seed) {
  Dataset dataset = exact;
  for (std::size_t i = 0; i < dataset.views.size(); ++i) {
    Random random(seed, i);
    for (Observation& seen : dataset.views[i].observations) {
      seen.pixel.x() += sigma_px * random.normal();
      seen.pixel.y() += sigma_px * random.normal();
      seen.covariance_px2 = sigma_px * sigma_px * Matrix2::Identity();
    }
  }
  return dataset;
}

Dataset with_views(const Dataset& dataset, const std::vector<std::size_t>& views) {
  Dataset some{dataset.image_size, dataset.boards, {}, {}};
  for (const std::size_t view : views) some.views.push_back(dataset.views[view]);
  return some;
}

// Number of frames, sd, squared error, processor time.
Values measured(const Dataset& some, const Camera& truth, const CalibrateOptions& options,
                double seconds) {
  Lap lap;
  const Calibration calibration = calibrate(some, options);
  seconds += lap();
  const auto count = static_cast<double>(some.views.size());
  if (!is_answer(calibration.status) || !calibration.claim) return {count, NAN, NAN, seconds};
  const auto samples = common_samples(truth.image_size, {}, {});
  const ProjectionUncertainty claim = projection_uncertainty(
      *calibration.claim, calibration.projection.front().grid, samples, kInfinitelyFar);
  const auto difference = lens_difference(truth, *calibration.camera, samples, kInfinitelyFar);
  const double squared = difference ? std::pow(difference->rms_px, 2) / 2 : NAN;
  return {count, claim.region_px, squared, seconds};
}

std::vector<Values> measure(const Dataset& exact, const StudyOptions& study, std::uint64_t trial) {
  const Dataset all = noisy(exact, study.number("sigma-px"), trial);
  CalibrateOptions options;
  options.model = study.text("model");
  options.num_threads = 1;
  std::vector<std::size_t> frames(all.views.size());
  std::iota(frames.begin(), frames.end(), std::size_t{0});
  std::vector<double> times_s;
  for (const std::size_t frame : frames)
    times_s.push_back(static_cast<double>(frame) / study.number("rate-hz"));
  Lap lap;
  const FrameSelection chosen = choose_frames(all, times_s, options);
  const double seconds = lap();
  const auto evenly = internal::spread_indices(frames.size(), chosen.used.size());
  const Camera& truth = exact.truth->camera;
  Values row = measured(with_views(all, chosen.used), truth, options, seconds);
  for (const std::vector<std::size_t>& views : {frames, evenly})
    for (const Value& value : measured(with_views(all, views), truth, options, 0))
      row.push_back(value);
  return {row};
}

std::vector<Task> frames_tasks(const StudyOptions& options) {
  std::vector<Task> tasks;
  for (const std::string& file : options.inputs) {
    const MovingScene scene = read_moving_scene(file);
    const auto exact =
        std::make_shared<const Dataset>(exact_dataset(scene, camera_poses(scene, 1), nullptr));
    tasks.push_back({std::filesystem::path(file).stem().string(),
                     [=](std::uint64_t trial) { return measure(*exact, options, trial); }});
  }
  return tasks;
}

}  // namespace

Study frames_study() {
  const std::vector<Figure> figures = {
      rows_in("trials"),
      mean_of("frames", "frames_all", 0),
      mean_of("used", "frames_chosen", 0),
      mean_of("sd, all", "sd_all", 4),
      mean_of("sd, chosen", "sd_chosen", 4),
      mean_of("sd, every Nth", "sd_evenly", 4),
      ratio_of("chosen : all", "sd_chosen", "sd_all", 2),
      ratio_of("chosen : every Nth", "sd_chosen", "sd_evenly", 2),
      root_ratio_of("error, chosen : all", "error2_chosen", "error2_all", 2),
      root_ratio_of("error, chosen : every Nth", "error2_chosen", "error2_evenly", 2),
      ratio_of("cpu, chosen : all", "cpu_s_chosen", "cpu_s_all", 3)};
  return {.name = "frames",
          .summary = "the choice of a clip's frames beside all of them and every Nth",
          .inputs = "scenes",
          .count = 10,
          .options = {{"model", "auto", "of all calibrations"},
                      {"rate-hz", "30", "frames a second"},
                      {"sigma-px", "0.1", "noise of the corners"}},
          .columns = {"frames_chosen", "sd_chosen", "error2_chosen", "cpu_s_chosen", "frames_all",
                      "sd_all", "error2_all", "cpu_s_all", "frames_evenly", "sd_evenly",
                      "error2_evenly", "cpu_s_evenly"},
          .tasks = frames_tasks,
          .tables = {{{"task"}, figures}}};
}

}  // namespace tagcal
