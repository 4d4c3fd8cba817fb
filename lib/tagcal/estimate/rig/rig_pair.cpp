#include "tagcal/estimate/rig/rig_pair.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

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

// The derivative of a function of a lens by its free parameters, by central differences.
template <typename Function>
MatrixXd by_lens(const UncertainCamera& camera, const Function& of_lens) {
  if (!camera.model) return MatrixXd(of_lens(camera.camera.lens).size(), 0);
  const std::vector<double> values = camera.model->free_values(camera.camera.lens);
  MatrixXd by(of_lens(camera.camera.lens).size(), std::ssize(values));
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double h = 1e-6 * std::max(1.0, std::abs(values[k]));  // numeric: between both roundings
    const auto at = [&](double value) {
      std::vector<double> moved = values;
      moved[k] = value;
      return of_lens(*camera.model->lens(moved, camera.camera.image_size));
    };
    by.col(static_cast<Index>(k)) = (at(values[k] + h) - at(values[k] - h)) / (2 * h);
  }
  return by;
}

// How the pixel of a point at `distance` on the axis of the first camera, in the second one,
// depends on the parameters of the rig if it is kept at its pixel in the first.
MatrixXd pixel_by_parameters(const UncertainPair& pair, const Pose& b_from_a, double distance,
                             const PointJacobian& by_point, const Vector2d& centre) {
  const Eigen::Quaterniond& turn = b_from_a.rotation();
  const Vector3d along = turn * Vector3d(distance * Vector3d::UnitZ());
  const Vector3d point = b_from_a * Vector3d(distance * Vector3d::UnitZ());
  const MatrixXd by = by_parameters(pair);
  MatrixXd of_pixel = by_point * (by.bottomRows<3>() - cross_matrix(along) * by.topRows<3>());
  const auto add = [&](Index lens, const MatrixXd& by_its) {
    if (by_its.cols() > 0) of_pixel.middleCols(lens, by_its.cols()) += by_its;
  };
  const Vector2d pixel = *project(pair.b.camera.lens, point);
  add(pair.lens_b,
      by_lens(pair.b, [&](const Lens& lens) { return project(lens, point).value_or(pixel); }));
  add(pair.lens_a, by_lens(pair.a, [&](const Lens& lens) -> Vector2d {
        const auto ray = ray_in_camera(lens, centre);
        const Vector3d direction = ray ? ray->direction : Vector3d::UnitZ();
        return by_point * (turn * Vector3d(distance * direction));
      }));
  return of_pixel;
}

// The uncertainty of the depth of a point at `distance` on the axis of the first camera, as its
// second pixel tells it. No value if the second camera does not see the point.
std::optional<DepthUncertainty> depth_uncertainty(const UncertainPair& pair, const Pose& b_from_a,
                                                  double distance) {
  const Vector3d axis = Vector3d::UnitZ(), point = b_from_a * Vector3d(distance * axis);
  PointJacobian by_point;
  const auto pixel =
      std::visit([&](const auto& lens) { return lens.project(point, &by_point, nullptr); },
                 pair.b.camera.lens);
  const auto centre = project(pair.a.camera.lens, Vector3d(distance * axis));
  if (!pixel || !centre) return std::nullopt;
  const Vector2d by_depth = by_point * (b_from_a.rotation() * axis);
  if (!(by_depth.squaredNorm() > 0)) return std::nullopt;
  const MatrixXd of_pixel = pixel_by_parameters(pair, b_from_a, distance, by_point, *centre);
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
