#include "tagcal/estimate/calibration_diff.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>

#include "tagcal/error.hpp"
#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/estimate/projection_uncertainty.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::optional<Correspondence> point_at(const Lens& lens, const Vector2d& pixel, double distance_m) {
  const std::optional<Ray> ray = ray_in_camera(lens, pixel);
  if (!ray) return std::nullopt;
  return Correspondence{(std::isfinite(distance_m) ? distance_m : 1.0) * ray->direction, pixel};
}

// The rotation that fits best, by Gauss-Newton, in which the residuals are nearly linear. Removes
// points from the view that a rotation moves out of the domain of the lens.
std::optional<Pose> best_rotation(ViewProblem& view, const Lens& lens) {
  Pose pose;
  for (int i = 0; i < 50; ++i) {
    std::erase_if(view.correspondences.own(),
                  [&](const Correspondence& c) { return !in_domain(lens, pose * c.point); });
    constexpr std::size_t kFewest = 6;  // two a degree of freedom of a rotation
    if (view.correspondences.size() < kFewest) return std::nullopt;
    const auto r = reprojection(view, lens, {}, pose);
    if (!r) return std::nullopt;
    const auto by_turn = r->by_pose.leftCols<3>();
    const Vector3d turn =
        (by_turn.transpose() * by_turn).ldlt().solve(by_turn.transpose() * r->residuals);
    if (!turn.allFinite()) return std::nullopt;
    pose = Pose(exp_rotation(-turn) * pose.rotation(), Vector3d::Zero());
    if (turn.norm() < 1e-13) break;  // numeric: a step of the size of rounding
  }
  return pose;
}

std::optional<Pose> best_pose(ViewProblem& view, const Lens& lens, double distance_m) {
  const std::optional<Pose> rotated = best_rotation(view, lens);
  if (!rotated || !std::isfinite(distance_m)) return rotated;
  // The target frame is moved to the points, because the solver's unit of length is the distance of
  // the target.
  ViewProblem shifted = view;
  const Pose ahead(Eigen::Quaterniond::Identity(), {0, 0, distance_m});
  for (Correspondence& c : shifted.correspondences.own()) c.point = ahead.inverse() * c.point;
  const auto refined = refine_view_pose(shifted, lens, *rotated * ahead);
  if (!refined) return std::nullopt;
  return refined->camera_from_target * ahead.inverse();
}

void fill_grid(const Lens& a, const Lens& b, LensDifference& d) {
  const double no_value = std::numeric_limits<double>::quiet_NaN();
  d.u_px = d.v_px = Eigen::MatrixXd::Constant(d.grid.rows, d.grid.columns, no_value);
  for (int row = 0; row < d.grid.rows; ++row) {
    for (int column = 0; column < d.grid.columns; ++column) {
      const auto c = point_at(a, d.grid.pixel(column, row), d.distance_m);
      if (!c) continue;
      const std::optional<Vector2d> pixel = project(b, d.b_from_a * c->point);
      if (!pixel) continue;
      d.u_px(row, column) = pixel->x() - c->pixel.x();
      d.v_px(row, column) = pixel->y() - c->pixel.y();
    }
  }
}

}  // namespace

std::optional<LensDifference> lens_difference(const Camera& a, const Camera& b,
                                              std::span<const Vector2d> samples,
                                              double distance_m) {
  if (!(a.image_size == b.image_size))
    throw Error("the images have different sizes: " + std::to_string(a.image_size.width) + " x " +
                std::to_string(a.image_size.height) + " and " + std::to_string(b.image_size.width) +
                " x " + std::to_string(b.image_size.height));
  ViewProblem view;
  for (const Vector2d& pixel : samples) {
    const auto c = point_at(a.lens, pixel, distance_m);
    if (c && in_domain(b.lens, c->point)) view.correspondences.push_back(*c);
  }
  const std::optional<Pose> pose = best_pose(view, b.lens, distance_m);
  if (!pose) return std::nullopt;
  LensDifference d{distance_m, *pose, {a.image_size}, {}, {}, 0, 0};
  for (const Vector2d& r : residuals_px(view.correspondences, b.lens, *pose)) {
    d.rms_px += r.squaredNorm();
    d.max_px = std::max(d.max_px, r.norm());
  }
  d.rms_px = std::sqrt(d.rms_px / static_cast<double>(view.correspondences.size()));
  fill_grid(a.lens, b.lens, d);
  return d;
}

std::vector<Vector2d> common_samples(const ImageSize& size, const SeenRegion& a,
                                     const SeenRegion& b) {
  std::vector<Vector2d> samples = ImageGrid{size, 33, 21}.pixels();
  for (const SeenRegion* seen : {&b, &a})
    if (!seen->hull().empty()) samples = seen->samples();
  for (const SeenRegion* seen : {&a, &b})
    if (!seen->hull().empty())
      std::erase_if(samples, [&](const Vector2d& pixel) { return !seen->contains(pixel); });
  return samples;
}

namespace {

bool has_ray(const Lens& lens, const Vector2d& pixel) {
  const std::optional<Ray> ray = ray_in_camera(lens, pixel);
  return ray && in_domain(lens, ray->direction);
}

bool is_exact(const UncertainLens& lens) {
  return lens.model == nullptr || lens.covariance.size() == 0 || !lens.covariance.allFinite();
}

// A L with C = L L', whose product with its transpose is A C A'; no columns of an exact lens.
Eigen::MatrixXd effect(const UncertainLens& lens, std::span<const Vector2d> samples,
                       double distance_m) {
  if (is_exact(lens)) return Eigen::MatrixXd(2 * samples.size(), 0);
  const Eigen::LDLT<Eigen::MatrixXd> ldlt{Eigen::MatrixXd(lens.covariance)};
  const Eigen::VectorXd d = ldlt.vectorD().cwiseMax(0).cwiseSqrt();
  const Eigen::MatrixXd lower = ldlt.matrixL();
  const Eigen::MatrixXd root = ldlt.transpositionsP().transpose() * (lower * d.asDiagonal());
  return aligned_jacobian(lens, samples, distance_m) * root;
}

}  // namespace

std::optional<DifferenceTest> difference_test(const UncertainLens& a, const UncertainLens& b,
                                              std::span<const Vector2d> samples,
                                              const LensDifference& difference) {
  if (is_exact(a) && is_exact(b)) return std::nullopt;
  std::vector<Vector2d> common;
  for (const Vector2d& pixel : samples)
    if (has_ray(a.lens, pixel) && has_ray(b.lens, pixel)) common.push_back(pixel);
  constexpr std::size_t kFewest = 6;  // as lens_difference
  if (common.size() < kFewest) return std::nullopt;
  const Eigen::MatrixXd of_a = effect(a, common, difference.distance_m);
  const Eigen::MatrixXd of_b = effect(b, common, difference.distance_m);
  if (of_a.rows() != of_b.rows()) return std::nullopt;
  Eigen::MatrixXd both(of_a.rows(), of_a.cols() + of_b.cols());
  both << of_a, of_b;
  const Eigen::MatrixXd gram = both.transpose() * both;
  const double mean = gram.trace() / static_cast<double>(common.size());
  if (!(mean > 0)) return std::nullopt;
  const double freedom = gram.trace() * gram.trace() / gram.squaredNorm();
  // The cube root of chi-square over its degrees of freedom is nearly normal.
  const double variance = 2 / (9 * freedom);
  const double ratio = difference.rms_px * difference.rms_px / mean;
  return DifferenceTest{std::sqrt(mean), (std::cbrt(ratio) - (1 - variance)) / std::sqrt(variance)};
}

}  // namespace tagcal
