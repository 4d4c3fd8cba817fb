#include "tagcal/estimate/rig/rig_pair.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

#include "tagcal/camera/kernels/projection_rows.hpp"
#include "tagcal/uncertainty/rays/seen_ray.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kDepths[] = {1, 3, 10, 30};  // numeric: metres, as users ask for them

// Steps of b_from_a by all parameters of the rig (6 x n).
MatrixXd by_parameters(const UncertainPair& pair) {
  const auto by = pair_by_places(pair.a_from_rig, pair.b_from_rig);
  MatrixXd all = MatrixXd::Zero(6, pair.covariance.cols());
  if (pair.place_a) all.middleCols<6>(*pair.place_a) = by.leftCols<6>();
  if (pair.place_b) all.middleCols<6>(*pair.place_b) = by.rightCols<6>();
  return all;
}

std::span<const FreeParameter> free_of(const UncertainCamera& camera) {
  return camera.model ? camera.model->free() : std::span<const FreeParameter>();
}

// How the pixel of a point at `distance` on the axis of the first camera, in the second one,
// depends on the parameters of the rig if it is kept at its pixel in the first.
MatrixXd pixel_by_parameters(const UncertainPair& pair, const Pose& b_from_a, double distance,
                             const ProjectionRows& in_b, const Vector2d& in_a) {
  MatrixXd of_pixel = in_b.by_pose * by_parameters(pair);
  of_pixel.middleCols(pair.lens_b, in_b.by_parameters.cols()) += in_b.by_parameters;
  if (pair.a.num_free() == 0) return of_pixel;
  // At a pixel that is kept, the lens of the first moves the ray.
  if (const auto ray = seen_ray(pair.a.camera.lens, in_a, free_of(pair.a)))
    of_pixel.middleCols(pair.lens_a, pair.a.num_free()) -= distance * in_b.by_pose.rightCols<3>() *
                                                           b_from_a.rotation_matrix() *
                                                           ray->by_pixel * ray->pixel_by_parameters;
  return of_pixel;
}

// The uncertainty of the depth of a point at `distance` on the axis of the first camera, as its
// second pixel tells it. No value if the second camera does not see the point.
std::optional<DepthUncertainty> depth_uncertainty(const UncertainPair& pair, const Pose& b_from_a,
                                                  double distance) {
  const Vector3d axis = Vector3d::UnitZ();
  const std::array<Vector3d, 1> point = {distance * axis};
  const auto in_b = projection_rows(pair.b.camera.lens, b_from_a, point, free_of(pair.b));
  const auto in_a = project(pair.a.camera.lens, point[0]);
  if (!in_b || !in_a) return std::nullopt;
  const Vector2d by_depth = in_b->by_pose.rightCols<3>() * (b_from_a.rotation() * axis);
  if (!(by_depth.squaredNorm() > 0)) return std::nullopt;
  const MatrixXd of_pixel = pixel_by_parameters(pair, b_from_a, distance, *in_b, *in_a);
  const VectorXd depth = -of_pixel.transpose() * by_depth / by_depth.squaredNorm();
  const VectorXd with_all = pair.covariance * depth;
  const double all = std::max(0.0, depth.dot(with_all));
  // The part that would vanish if the lenses were known.
  const VectorXd with_lenses = with_all.tail(pair.inverse_of_lenses.cols());
  const double part = with_lenses.dot(pair.inverse_of_lenses * with_lenses);
  return DepthUncertainty{distance, std::sqrt(all), std::sqrt(std::clamp(part, 0.0, all))};
}

}  // namespace

MatrixXd inverse_of_last(const MatrixXd& covariance, Index size) {
  if (size == 0) return {};  // all lenses are exact
  const MatrixXd last = covariance.bottomRightCorner(size, size);
  return last.completeOrthogonalDecomposition().pseudoInverse();
}

Matrix6 covariance_between(const Pose& a_from_rig, const Pose& b_from_rig,
                           std::optional<Index> place_a, std::optional<Index> place_b,
                           const MatrixXd& covariance) {
  const auto by = pair_by_places(a_from_rig, b_from_rig);
  const std::optional<Index> at[] = {place_a, place_b};
  Matrix6 between = Matrix6::Zero();
  for (int i = 0; i < 2; ++i)
    for (int k = 0; k < 2; ++k)
      if (at[i] && at[k])
        between += by.middleCols<6>(6 * i) * covariance.block<6, 6>(*at[i], *at[k]) *
                   by.middleCols<6>(6 * k).transpose();
  return between;
}

void report_place(const UncertainPair& pair, RigPair& result) {
  result.b_from_a = pair.b_from_rig * pair.a_from_rig.inverse();
  result.covariance = covariance_between(pair.a_from_rig, pair.b_from_rig, pair.place_a,
                                         pair.place_b, pair.covariance);
  const Vector3d t = result.b_from_a.translation();
  result.baseline_m = t.norm();
  const Eigen::Matrix3d of_t = result.covariance.bottomRightCorner<3, 3>();
  if (result.baseline_m > 0)
    result.sigma_baseline_m = std::sqrt(std::max(0.0, t.dot(of_t * t))) / result.baseline_m;
  for (const double distance : kDepths)
    if (const auto depth = depth_uncertainty(pair, result.b_from_a, distance))
      result.depths.push_back(*depth);
}

}  // namespace tagcal::internal

namespace tagcal {

std::vector<RigPair> pairs_of(const KnownRig& rig) {
  if (rig.covariance.size() == 0) return {};
  const Eigen::MatrixXd covariance = rig.covariance;
  const Eigen::MatrixXd inverse =
      internal::inverse_of_last(covariance, covariance.rows() - rig.first_of_lens(0));
  std::vector<RigPair> pairs;
  for (std::size_t a = 0; a < rig.cameras.size(); ++a)
    for (std::size_t b = a + 1; b < rig.cameras.size(); ++b) {
      const KnownRig::Member &of_a = rig.cameras[a], &of_b = rig.cameras[b];
      RigPair& pair = pairs.emplace_back();
      pair.a = a;
      pair.b = b;
      internal::report_place({of_a.camera, of_b.camera, of_a.camera_from_rig, of_b.camera_from_rig,
                              6 * static_cast<Eigen::Index>(a), 6 * static_cast<Eigen::Index>(b),
                              rig.first_of_lens(a), rig.first_of_lens(b), covariance, inverse},
                             pair);
    }
  return pairs;
}

}  // namespace tagcal
