#include "tagcal/uncertainty/triangulate.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/solvers/numeric/minimise.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"
#include "tagcal/uncertainty/policy/policy.hpp"
#include "tagcal/uncertainty/rays/seen_ray.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// A point origin + direction / inverse_m, which may be infinitely far: the length of `direction` is
// 1. With x = (direction, inverse_m) in homogeneous coordinates about `origin`, the frame of a
// camera at (R, t) has it at R direction + inverse_m (R origin + t), up to scale.
struct PointOnRay {
  Vector3d direction;
  double inverse_m = 0;  // of the distance; negative behind the origin
};

class SeenPoint {
 public:
  SeenPoint(const KnownRig& rig, std::span<const SeenPixel> seen) : rig_(rig), seen_(seen) {
    for (const SeenPixel& pixel : seen) {
      const Pose& place = rig.cameras[pixel.camera].camera_from_rig;
      const Pose back = place.inverse();
      const auto ray = seen_ray(rig.cameras[pixel.camera].camera.camera.lens, pixel.at.pixel);
      if (!ray) return;
      rays_.push_back(back.rotation() * ray->direction);
      centres_.push_back(back.translation());
    }
  }

  bool has_rays() const { return rays_.size() == seen_.size(); }
  const Vector3d& origin() const { return centres_.front(); }

  // Where the first ray comes nearest to the others, by the cross products of the rays.
  PointOnRay start() const {
    double numerator = 0, denominator = 0;
    for (std::size_t i = 1; i < rays_.size(); ++i) {
      const Vector3d turn = rays_[i].cross(rays_.front());
      const Vector3d shift = rays_[i].cross(centres_.front() - centres_[i]);
      numerator -= shift.dot(turn);
      denominator += shift.squaredNorm();
    }
    return {rays_.front(), denominator > 0 ? numerator / denominator : 0};
  }

  // Residuals, their Jacobian by (two steps across the direction, inverse_m), and by places and
  // lenses. No value outside the domain of a lens.
  struct Rows {
    VectorXd residuals;
    Eigen::Matrix<double, Eigen::Dynamic, 3> by_point;
    MatrixXd by_rig;
  };
  std::optional<Rows> rows(const PointOnRay& point, bool with_rig) const {
    const Eigen::Index n = 2 * std::ssize(seen_);
    Rows rows{VectorXd(n), MatrixXd(n, 3), {}};
    if (with_rig) rows.by_rig = MatrixXd::Zero(n, rig_.covariance.cols());
    const Eigen::Matrix<double, 3, 2> basis = across(point.direction);
    for (Eigen::Index i = 0; i < n; i += 2) {
      const SeenPixel& pixel = seen_[static_cast<std::size_t>(i / 2)];
      const KnownRig::Member& member = rig_.cameras[pixel.camera];
      const Pose& place = member.camera_from_rig;
      // Scaled by inverse_m, so that infinitely far points have coordinates too.
      const Pose scaled(place.rotation(), point.inverse_m * place.translation());
      const std::array<Vector3d, 1> x = {point.direction + point.inverse_m * origin()};
      const auto at =
          projection_rows(member.camera.camera.lens, scaled, x,
                          with_rig && member.camera.model ? member.camera.model->free()
                                                          : std::span<const FreeParameter>());
      if (!at) return std::nullopt;
      const Eigen::Matrix<double, 2, 3> by_x = at->by_pose.rightCols<3>();
      rows.residuals.segment<2>(i) = pixel.at.pixel - at->pixels[0];
      rows.by_point.block<2, 2>(i, 0) = by_x * place.rotation_matrix() * basis;
      rows.by_point.block<2, 1>(i, 2) = by_x * (place * origin());
      if (!with_rig) continue;
      const auto c = static_cast<Eigen::Index>(pixel.camera);
      rows.by_rig.block<2, 3>(i, 6 * c) = at->by_pose.leftCols<3>();
      rows.by_rig.block<2, 3>(i, 6 * c + 3) = point.inverse_m * by_x;
      rows.by_rig.block(i, rig_.first_of_lens(pixel.camera), 2, at->by_parameters.cols()) =
          at->by_parameters;
    }
    return rows;
  }

  // The covariance of the residuals at a point.
  std::optional<MatrixXd> covariance(const PointOnRay& point) const {
    const bool has_rig = rig_.covariance.size() > 0;
    const auto at = rows(point, has_rig);
    if (!at) return std::nullopt;
    MatrixXd sum = MatrixXd::Zero(at->residuals.size(), at->residuals.size());
    if (has_rig) sum = at->by_rig * rig_.covariance * at->by_rig.transpose();
    constexpr double kLeast = policy::kLeastPixelNoise * policy::kLeastPixelNoise;
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      const auto k = 2 * static_cast<Eigen::Index>(i);
      const double error = rig_.cameras[seen_[i].camera].camera_error_px.value_or(0);
      sum.block<2, 2>(k, k) += seen_[i].at.covariance_px2;
      sum.diagonal().segment<2>(k).array() += error * error + kLeast;
    }
    return sum;
  }

 private:
  const KnownRig& rig_;
  std::span<const SeenPixel> seen_;
  std::vector<Vector3d> rays_, centres_;  // in the frame of the rig
};

// The residuals over their covariance (solvers/numeric/minimise.hpp).
struct PointProblem {
  using State = PointOnRay;
  struct Equations {
    double cost = 0;
    Matrix3d information;
    Vector3d gradient;

    std::optional<DampedStep<Vector3d>> step(double damping) const {
      Matrix3d damped = information;
      damped.diagonal() *= 1 + damping;
      const Eigen::LDLT<Matrix3d> ldlt(damped);
      if (ldlt.info() != Eigen::Success || !ldlt.isPositive()) return std::nullopt;
      const Vector3d step = ldlt.solve(gradient);
      return DampedStep<Vector3d>{step, step.dot(gradient)};
    }
  };

  const SeenPoint& seen;
  const Eigen::LLT<MatrixXd>& covariance;

  std::optional<Equations> at(const PointOnRay& point) const {
    const auto rows = seen.rows(point, false);
    if (!rows) return std::nullopt;
    const VectorXd r = covariance.matrixL().solve(rows->residuals);
    const MatrixXd j = covariance.matrixL().solve(rows->by_point);
    return Equations{r.squaredNorm(), j.transpose() * j, j.transpose() * r};
  }

  PointOnRay stepped(const PointOnRay& point, const Vector3d& step) const {
    const Vector3d direction = point.direction + across(point.direction) * step.head<2>();
    const double length = direction.norm();
    return {direction / length, (point.inverse_m + step.z()) / length};
  }
};

struct PointFit {
  PointOnRay point;
  PointProblem::Equations at;
};

// The covariance of the residuals is that at the point before, which is good enough after one turn.
std::optional<PointFit> fit_point(const SeenPoint& seen) {
  PointFit fit{seen.start(), {}};
  for (int turn = 0; turn < 2; ++turn) {
    const auto covariance = seen.covariance(fit.point);
    if (!covariance) return std::nullopt;
    const Eigen::LLT<MatrixXd> llt(*covariance);
    if (llt.info() != Eigen::Success) return std::nullopt;
    const auto minimum = minimise(PointProblem{seen, llt}, fit.point);
    if (!minimum) return std::nullopt;
    fit = {minimum->state, minimum->at};
  }
  return fit;
}

double most_chi_square(std::size_t num_pixels) {
  return chi_square_quantile(2 * static_cast<double>(num_pixels) - 3, policy::kContradictionSigmas);
}

// The pixel without which the others agree best.
std::vector<std::size_t> contradicting_pixels(const KnownRig& rig,
                                              std::span<const SeenPixel> seen) {
  if (seen.size() == 2) return {0, 1};
  std::size_t worst = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    std::vector<SeenPixel> others(seen.begin(), seen.end());
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const auto fit = fit_point(SeenPoint(rig, others));
    if (fit && fit->at.cost < least) {
      least = fit->at.cost;
      worst = i;
    }
  }
  return {worst};
}

void check_seen(const KnownRig& rig, std::span<const SeenPixel> seen) {
  rig.check_covariance();
  std::vector<std::uint8_t> used(rig.cameras.size());
  for (const SeenPixel& pixel : seen) {
    if (pixel.camera >= rig.cameras.size())
      throw Error(fmt::format("triangulate: the rig has {} cameras, got the index {}",
                              rig.cameras.size(), pixel.camera));
    if (used[pixel.camera]++ != 0)
      throw Error(fmt::format("triangulate: {} is given twice", rig.cameras[pixel.camera].name));
  }
}

}  // namespace

std::string_view status_name(TriangulationStatus status) {
  static constexpr std::array<std::string_view, 5> kNames = {"ok", "few_cameras", "no_ray", "far",
                                                             "behind"};
  return kNames[static_cast<std::size_t>(status)];
}

TriangulatedPoint triangulate(const KnownRig& rig, std::span<const SeenPixel> seen) {
  check_seen(rig, seen);
  TriangulatedPoint result;
  if (seen.size() < 2) return result;
  result.status = TriangulationStatus::no_ray;
  const SeenPoint point(rig, seen);
  if (!point.has_rays()) return result;
  const auto fit = fit_point(point);
  if (!fit) {  // no point is before all cameras
    result.status = TriangulationStatus::behind;
    return result;
  }
  const auto& [direction, inverse_m] = fit->point;
  const Matrix3d covariance = fit->at.information.inverse();
  const VectorXd residuals = point.rows(fit->point, false)->residuals;
  for (std::size_t i = 0; i < seen.size(); ++i)
    result.residuals_px.emplace_back(residuals.segment<2>(2 * static_cast<Eigen::Index>(i)));
  result.rms_px = std::sqrt(residuals.squaredNorm() / static_cast<double>(seen.size()));
  result.chi_square = fit->at.cost;
  if (fit->at.cost > most_chi_square(seen.size()))
    result.contradicting = contradicting_pixels(rig, seen);
  const double sigma = std::sqrt(covariance(2, 2));
  if (!(std::abs(inverse_m) > policy::kFarSigmas * sigma)) {
    result.status = TriangulationStatus::far;
  } else if (inverse_m < 0) {
    result.status = TriangulationStatus::behind;
  } else {
    result.status = TriangulationStatus::ok;
    Matrix3d by_step;
    by_step << across(direction) / inverse_m, -direction / (inverse_m * inverse_m);
    result.point = {point.origin() + direction / inverse_m,
                    by_step * covariance * by_step.transpose()};
  }
  return result;
}

}  // namespace tagcal
