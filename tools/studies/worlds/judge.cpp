#include "judge.hpp"

#include "study/processor_time.hpp"

namespace tagcal {
namespace {

void describe(const World& world, Record& r) {
  const Scene& scene = world.scene;
  static_cast<WorldId&>(r) = world.id;
  r.model = scene.model;
  r.width = scene.camera.image_size.width;
  r.height = scene.camera.image_size.height;
  r.field_of_view_deg = world.field_of_view_deg;
  r.views = scene.num_views;
  r.tags_on_board = static_cast<int>(tags_of(scene.boards[0].board).size());
  r.border_bits = tag_kind(scene.boards[0].board)->border_bits;
  r.tag_px = world.tag_px;
  r.coverage = world.coverage;
  r.most_tilt_deg = world.most_tilt_deg;
  r.blur_px = scene.sensor.blur_px;
  r.noise_levels = scene.sensor.noise_levels;
  r.ink_spread_px = world.ink_spread_px;
  r.gamma = scene.sensor.gamma;
  r.pictures = world.pictures;
  r.occluders = static_cast<int>(scene.occluders.size());
}

void describe_defects(const Defects& d, Record& r) {
  r.defects = names_of(d);
  r.bend_x = d.bend.x();
  r.bend_y = d.bend.y();
  r.twist = d.twist;
  r.aspect = d.aspect;
  r.skew = d.skew;
  r.rows_px = d.rows_px;
  r.uneven_light = d.uneven_light;
  r.covariances = d.covariances;
}

// "code: sentence | code: sentence".
std::string joined(const std::vector<Finding>& findings) {
  std::string line;
  for (const Finding& finding : findings)
    line += (line.empty() ? "" : " | ") + finding.code + ": " + finding.sentence;
  return line;
}

// Right corners that the answer does not use, and grossly wrong ones that it does.
void judge_rejection(const Measured& m, const Calibration& c, Record& r) {
  std::vector<std::vector<char>> used;
  for (const auto& view : m.gross) used.emplace_back(view.size(), 0);
  for (const CalibratedView& view : c.views) std::ranges::fill(used[view.view], 1);
  for (const Outlier& o : c.outliers) used[o.view][o.corner] = 0;
  for (std::size_t v = 0; v < used.size(); ++v) {
    for (std::size_t i = 0; i < used[v].size(); ++i) {
      r.right_rejected += !used[v][i] && !m.gross[v][i];
      r.gross_kept += used[v][i] && m.gross[v][i];
    }
  }
}

void judge_auto(const Camera& truth, const Measured& m, Record& r) {
  study::Lap lap;
  const Calibration c = calibrate(m.dataset);
  r.calibrate_s = lap();
  r.status = status_name(c.status);
  r.answer = c.model;
  r.inliers = c.num_corners;
  r.left_out = static_cast<int>(c.outliers.size());
  r.model_error_px = c.model_error_px;
  r.findings = joined(c.findings);
  if (!is_answer(c.status)) return;
  judge_rejection(m, c, r);
  judge_lens(truth, c, r);
}

// Calibrates with the model that made the data, asked for by name.
void judge_own_model(const Camera& truth, const Dataset& dataset, Record& r) {
  CalibrateOptions options;
  options.model = r.model;
  study::Lap lap;
  const Calibration c = calibrate(dataset, options);
  r.own_s = lap();
  r.own_status = status_name(c.status);
  if (!is_answer(c.status)) return;
  Record own;
  judge_lens(truth, c, own);
  r.own_f_sd_px = own.f_sd_px;
  r.own_f_ratio = own.f_ratio;
  r.own_region_px = own.region_px;
  r.own_region_ratio = own.region_ratio;
  r.own_region_far_ratio = own.region_far_ratio;
  r.own_image_px = own.image_px;
  r.own_image_ratio = own.image_ratio;
}

}  // namespace

Record judge(const World& world) {
  Record r;
  describe(world, r);
  describe_defects(world.defects, r);
  const Camera& truth = world.scene.camera;
  const Measured measured =
      world.id.mode == kPixels ? render_and_detect(world, r) : project_corners(world, r);
  for (const auto& view : measured.gross) r.gross += static_cast<int>(std::ranges::count(view, 1));
  judge_auto(truth, measured, r);
  judge_own_model(truth, measured.dataset, r);
  return r;
}

}  // namespace tagcal
