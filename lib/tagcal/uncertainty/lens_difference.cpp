#include "tagcal/uncertainty/lens_difference.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <string>

#include "tagcal/camera/kernels/projection_rows.hpp"
#include "tagcal/error.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"
#include "tagcal/uncertainty/policy/policy.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Points along rays of lens a (its camera frame), and their pixels.
struct Samples {
  std::vector<Vector3d> points;
  std::vector<Vector2d> pixels;
};

std::optional<Vector3d> point_at(const Lens& lens, const Vector2d& pixel, double distance_m) {
  const std::optional<Ray> ray = ray_in_camera(lens, pixel);
  if (!ray) return std::nullopt;
  return Vector3d((std::isfinite(distance_m) ? distance_m : 1.0) * ray->direction);
}

// Keeps the samples whose points are in the domain of a lens that is moved.
void keep_visible(Samples& samples, const Lens& lens, const Pose& b_from_a) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    if (!in_domain(lens, b_from_a * samples.points[i])) continue;
    samples.points[kept] = samples.points[i];
    samples.pixels[kept++] = samples.pixels[i];
  }
  samples.points.resize(kept);
  samples.pixels.resize(kept);
}

// Projected pixels less those of the samples (2n).
VectorXd residuals(const std::vector<Vector2d>& projected, const Samples& samples) {
  VectorXd r(2 * static_cast<Eigen::Index>(projected.size()));
  for (std::size_t i = 0; i < projected.size(); ++i)
    r.segment<2>(2 * static_cast<Eigen::Index>(i)) = projected[i] - samples.pixels[i];
  return r;
}

// The Gauss-Newton step, by the columns' Jacobian.
template <typename Columns>
VectorXd step_of(const Columns& by_motion, const VectorXd& r) {
  return -(by_motion.transpose() * by_motion).ldlt().solve(by_motion.transpose() * r);
}

// The rotation that fits best, by Gauss-Newton, in which the residuals are nearly linear. Removes
// samples that a rotation moves out of the domain of the lens.
std::optional<Pose> best_rotation(Samples& samples, const Lens& lens) {
  Pose pose;
  for (int i = 0; i < 50; ++i) {
    keep_visible(samples, lens, pose);
    constexpr std::size_t kFewest = 6;  // two a degree of freedom of a rotation
    if (samples.points.size() < kFewest) return std::nullopt;
    const auto rows = projection_rows(lens, pose, samples.points);
    if (!rows) return std::nullopt;
    const Vector3d turn = step_of(rows->by_pose.leftCols<3>(), residuals(rows->pixels, samples));
    if (!turn.allFinite()) return std::nullopt;
    pose = Pose(exp_rotation(turn) * pose.rotation(), Vector3d::Zero());
    if (turn.norm() < 1e-13) break;  // numeric: a step of the size of rounding
  }
  return pose;
}

// The pose that fits best, from the best rotation: Gauss-Newton steps, halved until they lower the
// cost.
std::optional<Pose> best_pose(Samples& samples, const Lens& lens, double distance_m) {
  std::optional<Pose> pose = best_rotation(samples, lens);
  if (!pose || !std::isfinite(distance_m)) return pose;
  auto rows = projection_rows(lens, *pose, samples.points);
  if (!rows) return std::nullopt;
  VectorXd r = residuals(rows->pixels, samples);
  for (int i = 0; i < 50; ++i) {
    rows->by_pose.rightCols<3>() *= distance_m;  // scales the columns like those of the rotation
    Vector6d step = step_of(rows->by_pose, r);
    if (!step.allFinite()) return std::nullopt;
    const double cost = r.squaredNorm();
    for (;; step /= 2) {
      if (step.norm() < 1e-13) return pose;  // numeric: a step of the size of rounding
      Vector6d metric = step;
      metric.tail<3>() *= distance_m;
      const Pose next = retract(*pose, metric);
      auto there = projection_rows(lens, next, samples.points);
      if (!there) continue;
      VectorXd r_there = residuals(there->pixels, samples);
      if (!(r_there.squaredNorm() < cost)) continue;
      pose = next;
      rows = std::move(there);
      r = std::move(r_there);
      break;
    }
  }
  return pose;
}

void fill_grid(const Lens& a, const Lens& b, LensDifference& d) {
  const double no_value = std::numeric_limits<double>::quiet_NaN();
  d.u_px = d.v_px = Eigen::MatrixXd::Constant(d.grid.rows, d.grid.columns, no_value);
  for (int row = 0; row < d.grid.rows; ++row) {
    for (int column = 0; column < d.grid.columns; ++column) {
      const Vector2d node = d.grid.pixel(column, row);
      const std::optional<Vector3d> x_in_a = point_at(a, node, d.distance_m);
      if (!x_in_a) continue;
      const std::optional<Vector2d> pixel = project(b, d.b_from_a * *x_in_a);
      if (!pixel) continue;
      d.u_px(row, column) = pixel->x() - node.x();
      d.v_px(row, column) = pixel->y() - node.y();
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
  Samples both;  // visible in both lenses
  for (const Vector2d& pixel : samples) {
    const std::optional<Vector3d> x_in_a = point_at(a.lens, pixel, distance_m);
    if (!x_in_a) continue;
    both.points.push_back(*x_in_a);
    both.pixels.push_back(pixel);
  }
  keep_visible(both, b.lens, Pose());
  const std::optional<Pose> pose = best_pose(both, b.lens, distance_m);
  if (!pose) return std::nullopt;
  LensDifference d{distance_m, *pose, {a.image_size}, {}, {}, 0, 0};
  std::vector<Vector2d> pixels(both.points.size());
  std::vector<std::uint8_t> valid(both.points.size());
  project(b.lens, *pose, both.points, pixels, valid);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Vector2d r = pixels[i] - both.pixels[i];
    d.rms_px += r.squaredNorm();
    d.max_px = std::max(d.max_px, r.norm());
  }
  d.rms_px = std::sqrt(d.rms_px / static_cast<double>(pixels.size()));
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

std::string_view verdict_name(CheckVerdict verdict) {
  static constexpr std::string_view kNames[] = {"valid", "changed", "cannot_tell"};
  return kNames[static_cast<std::size_t>(verdict)];
}

CheckVerdict change_verdict(double in_sigmas, double smallest_px, double limit_px) {
  if (in_sigmas > policy::kCheckQuantile) return CheckVerdict::changed;
  return smallest_px <= limit_px ? CheckVerdict::valid : CheckVerdict::cannot_tell;
}

namespace {

bool has_ray(const Lens& lens, const Vector2d& pixel) {
  const std::optional<Ray> ray = ray_in_camera(lens, pixel);
  return ray && in_domain(lens, ray->direction);
}

// A L with C = L L', whose product with its transpose is A C A'; no columns of an exact lens.
Eigen::MatrixXd effect(const UncertainCamera& known, std::span<const Vector2d> samples,
                       double distance_m) {
  if (known.is_exact()) return Eigen::MatrixXd(2 * samples.size(), 0);
  const Eigen::LDLT<Eigen::MatrixXd> ldlt{Eigen::MatrixXd(known.covariance)};
  const Eigen::VectorXd d = ldlt.vectorD().cwiseMax(0).cwiseSqrt();
  const Eigen::MatrixXd lower = ldlt.matrixL();
  const Eigen::MatrixXd root = ldlt.transpositionsP().transpose() * (lower * d.asDiagonal());
  return aligned_jacobian(known, samples, distance_m) * root;
}

// Squares of differences at samples, in the principal directions of their covariance M = B B'.
class DirectionSquares {
 public:
  // Directions with less than a share of the whole variance count less.
  DirectionSquares(const Eigen::MatrixXd& roots, double share) : roots_(roots) {
    const Eigen::MatrixXd gram = roots.transpose() * roots;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
    const double least = share * gram.trace();
    weights_ = VectorXd::Zero(gram.rows());
    vectors_ = eigen.eigenvectors();
    constexpr double kRounding = 1e-12;  // numeric: of eigenvalues, relative to their sum
    for (Eigen::Index i = 0; i < gram.rows(); ++i) {
      const double variance = eigen.eigenvalues()[i];
      if (!(variance > kRounding * gram.trace())) continue;
      sum_ += variance / (variance + least);
      squares_ += std::pow(variance / (variance + least), 2);
      weights_[i] = 1 / (variance * (variance + least));
    }
  }

  double mean() const { return sum_; }                       // E T
  double freedom() const { return sum_ * sum_ / squares_; }  // nu
  double at(const VectorXd& difference) const {              // T
    return weights_.dot((vectors_.transpose() * (roots_.transpose() * difference)).cwiseAbs2());
  }

 private:
  const Eigen::MatrixXd& roots_;
  Eigen::MatrixXd vectors_;
  VectorXd weights_;
  double sum_ = 0, squares_ = 0;
};

// The differences of lens b from lens a at samples, after the motion of the camera. A sample whose
// ray one of the lenses does not have counts as equal.
VectorXd differences(const Lens& a, const Lens& b, std::span<const Vector2d> samples,
                     const LensDifference& difference) {
  VectorXd result = VectorXd::Zero(2 * static_cast<Eigen::Index>(samples.size()));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto point = point_at(a, samples[i], difference.distance_m);
    const auto pixel = point ? project(b, difference.b_from_a * *point) : std::nullopt;
    if (pixel) result.segment<2>(2 * static_cast<Eigen::Index>(i)) = *pixel - samples[i];
  }
  return result;
}

// The largest displacement of a sample by the change of the focal length or of the principal point
// of a lens that adds `needed` to T. Infinite if the lens is exact or has neither.
double shown_change(const UncertainCamera& known, std::span<const Vector2d> samples,
                    double distance_m, const DirectionSquares& squares, double needed) {
  if (known.is_exact()) return kInfinitelyFar;
  const Model& model = *known.model;
  const Eigen::MatrixXd rows = aligned_jacobian(known, samples, distance_m);
  VectorXd focal = VectorXd::Zero(rows.rows());
  std::vector<VectorXd> changes;
  const std::vector<double> values = model.free_values(known.camera.lens);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const VectorXd column = rows.col(static_cast<Eigen::Index>(i));
    const ParameterRole role = model.parameter(i).role;
    if (role == ParameterRole::focal_length) focal += values[i] * column;
    if (role == ParameterRole::principal_point) changes.push_back(column);
  }
  changes.push_back(focal);
  double most = 0;
  for (const VectorXd& change : changes) {
    double peak = 0;
    for (Eigen::Index i = 0; i + 1 < change.size(); i += 2)
      peak = std::max(peak, change.segment<2>(i).norm());
    if (peak > 0) most = std::max(most, peak * std::sqrt(needed / squares.at(change)));
  }
  return most > 0 ? most : kInfinitelyFar;
}

}  // namespace

std::optional<DifferenceTest> difference_test(const UncertainCamera& a, const UncertainCamera& b,
                                              std::span<const Vector2d> samples,
                                              const LensDifference& difference) {
  if (a.is_exact() && b.is_exact()) return std::nullopt;
  std::vector<Vector2d> common;
  for (const Vector2d& pixel : samples)
    if (has_ray(a.camera.lens, pixel) && has_ray(b.camera.lens, pixel)) common.push_back(pixel);
  constexpr std::size_t kFewest = 6;  // as lens_difference
  if (common.size() < kFewest) return std::nullopt;
  const Eigen::MatrixXd of_a = effect(a, common, difference.distance_m);
  const Eigen::MatrixXd of_b = effect(b, common, difference.distance_m);
  if (of_a.rows() != of_b.rows()) return std::nullopt;
  Eigen::MatrixXd both(of_a.rows(), of_a.cols() + of_b.cols());
  both << of_a, of_b;
  const double mean = both.squaredNorm() / static_cast<double>(common.size());
  if (!(mean > 0)) return std::nullopt;
  const bool is_one_kind = &kind_of(a.camera.lens) == &kind_of(b.camera.lens);
  const DirectionSquares squares(both, is_one_kind ? policy::kNegligibleShare : 1);
  const double freedom = squares.freedom();
  // The cube root of chi-square over its degrees of freedom is nearly normal.
  const double variance = 2 / (9 * freedom);
  const double ratio =
      squares.at(differences(a.camera.lens, b.camera.lens, common, difference)) / squares.mean();
  const double needed = noncentrality(freedom, policy::kCheckQuantile, policy::kCheckQuantile) *
                        squares.mean() / freedom;
  const double distance = difference.distance_m;
  return DifferenceTest{std::sqrt(mean), (std::cbrt(ratio) - (1 - variance)) / std::sqrt(variance),
                        std::min(shown_change(a, common, distance, squares, needed),
                                 shown_change(b, common, distance, squares, needed))};
}

}  // namespace tagcal
