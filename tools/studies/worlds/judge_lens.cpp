#include "judge.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

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

}  // namespace

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

}  // namespace tagcal
