#include "judge.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "study/processor_time.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using std::numbers::sqrt2;

// The larger of both; of a NaN and a number the number.
void raise(double& largest, double value) {
  if (!(value <= largest)) largest = value;
}

// If the answer has one focal length for both axes, the truth is their mean.
void judge_focal(const Camera& truth, const Calibration& answer, Record& record) {
  if (std::holds_alternative<Parallel>(answer.camera->lens) || answer.sigmas.empty()) return;
  const Model& model = Model::named(answer.model);
  const auto true_f = parameters(truth.lens);
  const bool tied = model.free().front().lens_parameters.size() > 1;
  const double f = tied ? (true_f[0] + true_f[1]) / 2 : true_f[0];
  record.f_px = parameters(answer.camera->lens)[0];
  record.f_sd_px = answer.sigmas[0];
  record.f_error_px = record.f_px - f;
  record.f_ratio = std::abs(record.f_error_px) / record.f_sd_px;
}

// Answer less truth at a node where the answer claims an uncertainty. `d` follows the truth's rays
// to the answer; if the answer has no pixel for the ray, its own ray is followed to the truth. No
// value if the truth has no ray; infinite if neither lens projects the other's ray.
std::optional<Vector2d> difference_at(const LensDifference& d, int row, int column,
                                      const Camera& truth, const Camera& answer) {
  const Vector2d error(d.u_px(row, column), d.v_px(row, column));
  if (error.allFinite()) return error;
  const Vector2d pixel = d.grid.pixel(column, row);
  if (!ray_in_camera(truth.lens, pixel)) return std::nullopt;
  const auto ray = ray_in_camera(answer.lens, pixel);
  const double distance = std::isfinite(d.distance_m) ? d.distance_m : 1;
  const auto seen =
      ray ? project(truth.lens, d.b_from_a.inverse() * (distance * ray->direction)) : std::nullopt;
  if (!seen) return Vector2d::Constant(HUGE_VAL);
  return pixel - *seen;
}

void judge_image(const ProjectionUncertainty& claim, const LensDifference& d, const Camera& truth,
                 const Camera& answer, Record& record) {
  int silent = 0;
  for (int row = 0; row < d.grid.rows; ++row) {
    for (int column = 0; column < d.grid.columns; ++column) {
      const double sd = claim.sigma_px(row, column);
      if (!std::isfinite(sd)) {
        silent += ray_in_camera(truth.lens, d.grid.pixel(column, row)).has_value();
        continue;
      }
      const auto error = difference_at(d, row, column, truth, answer);
      if (!error) continue;
      raise(record.image_px, sd);
      raise(record.image_error_px, error->norm() / sqrt2);
      raise(record.image_ratio, error->norm() / (sqrt2 * sd));
      raise(record.image_axis_ratio, error->cwiseAbs().maxCoeff() / sd);
    }
  }
  record.nodes_silent = std::max(record.nodes_silent, silent);
}

// Compares a calibration's focal length and projection with the truth, in units of the claimed
// standard deviations. Fills f_..., region_..., image_... and nodes_silent of the record; what is
// not claimed keeps its value.
void judge_lens(const Camera& truth, const Calibration& answer, Record& record) {
  judge_focal(truth, answer, record);
  const std::vector<Vector2d> samples = answer.seen.samples();
  for (const ProjectionUncertainty& claim : answer.projection) {
    const auto d = lens_difference(truth, *answer.camera, samples, claim.distance_m);
    // Lenses that cannot be compared count as infinitely wrong.
    const double error = d ? d->rms_px / sqrt2 : HUGE_VAL;
    const double ratio = error / claim.region_px;
    if (std::isfinite(claim.distance_m)) {
      record.region_px = claim.region_px;
      record.region_error_px = error;
      record.region_ratio = ratio;
    } else {
      record.region_far_ratio = ratio;
    }
    if (d) judge_image(claim, *d, truth, *answer.camera, record);
  }
}

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
