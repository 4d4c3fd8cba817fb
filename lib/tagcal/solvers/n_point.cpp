#include "tagcal/solvers/n_point.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "tagcal/error.hpp"
#include "tagcal/solvers/numeric/object_space.hpp"
#include "tagcal/solvers/numeric/point_spread.hpp"
#include "tagcal/solvers/numeric/projective_map.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Thickness below which a set of points starts as a plane: then the third column of R has little
// effect on the error, and the smallest eigenvectors contain only that column.
constexpr double kPlane = 0.1;

// Squared distance of unit quaternions below which two rotations are one minimum.
constexpr double kSame = 2.5e-9;

constexpr std::size_t kMostMinima = 24;

// Returns the rotation whose first two columns are nearest to those of v, with the points in front.
// These columns belong to the two longest axes and are the better determined ones.
Quaterniond start_from(const Vector9& v, const ObjectSpaceError& e) {
  const double sign = e.depth_map.dot(v) < 0 ? -1 : 1;
  const Vector3d a = sign * v.head<3>().normalized(), b = sign * v.segment<3>(3).normalized();
  const Vector3d sum = (a + b).normalized();
  const Vector3d across = a - b;
  const Vector3d difference = (across - sum * sum.dot(across)).normalized();
  Matrix3d r;
  r.col(0) = (sum + difference) / std::numbers::sqrt2;
  r.col(1) = (sum - difference) / std::numbers::sqrt2;
  r.col(2) = r.col(0).cross(r.col(1));
  const Quaterniond q(r);
  return q.coeffs().allFinite() && q.squaredNorm() > 0.5 ? q.normalized() : Quaterniond::Identity();
}

// Turns by 180 degrees about the mean ray, which takes a minimum with the points behind the camera
// to its twin in front (exactly, for a plane).
Quaterniond half_turn(const Quaterniond& q) { return Quaterniond(0, 0, 0, 1) * q; }

// Negates the tilt towards the mean ray, diag(1, 1, -1) R diag(1, 1, -1): under weak perspective
// both tilts of a plane have the same image (Oberkampf, DeMenthon & Davis, CVIU 1996).
Quaterniond other_tilt(const Quaterniond& q) { return {q.w(), -q.x(), -q.y(), q.z()}; }

// Rotations spread over SO(3): the group of the tetrahedron, turned by a rotation without symmetry.
// For few points, whose smallest eigenvectors span a space of several dimensions.
std::array<Quaterniond, 12> more_starts() {
  const Quaterniond generic = Quaterniond(0.83, 0.31, -0.27, 0.37).normalized();
  std::array<Quaterniond, 12> starts = {Quaterniond(1, 0, 0, 0), Quaterniond(0, 1, 0, 0),
                                        Quaterniond(0, 0, 1, 0), Quaterniond(0, 0, 0, 1)};
  for (unsigned k = 0; k < 8; ++k)
    starts[4 + k] = {0.5, k & 1 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 4 ? 0.5 : -0.5};
  for (Quaterniond& start : starts) start = start * generic;
  return starts;
}

class Search {
 public:
  explicit Search(const ObjectSpaceError& error) : error_(error) {}

  // Descends from a start to its minimum. If the points lie behind the camera, takes the twin.
  void from(const Quaterniond& start) {
    auto minimum = descend(error_.omega, depth(start) > 0 ? start : half_turn(start));
    if (minimum && !(depth(minimum->rotation) > 0))
      minimum = descend(error_.omega, half_turn(minimum->rotation));
    if (minimum && depth(minimum->rotation) > 0) add(*minimum);
  }

  const Solutions<RotationMinimum, kMostMinima>& minima() const { return minima_; }

 private:
  double depth(const Quaterniond& q) const { return error_.depth_map.dot(columns_of(q)); }

  void add(const RotationMinimum& minimum) {
    for (RotationMinimum& known : minima_) {
      const double cosine = std::abs(known.rotation.dot(minimum.rotation));
      if (2 - 2 * cosine > kSame) continue;
      if (minimum.error < known.error) known = minimum;
      return;
    }
    if (!minima_.full()) minima_.push_back(minimum);
  }

  const ObjectSpaceError& error_;
  Solutions<RotationMinimum, kMostMinima> minima_;
};

void search_from_eigenvectors(const ObjectSpaceError& e, int count, Search& search) {
  if (e.frame.thickness < kPlane) {
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(Matrix6d(e.omega.topLeftCorner<6, 6>()));
    for (int k = 0; k < count; ++k) {
      Vector9 v = Vector9::Zero();
      v.head<6>() = eigen.eigenvectors().col(k);
      search.from(start_from(v, e));
    }
  } else {
    const Eigen::SelfAdjointEigenSolver<Matrix9> eigen(e.omega);
    for (int k = 0; k < count; ++k) search.from(start_from(eigen.eigenvectors().col(k), e));
  }
}

bool in_front(const ObjectSpaceError& e, const Quaterniond& rotation,
              std::span<const Vector3d> points, std::span<const Vector3d> rays) {
  const Matrix3d camera_from_points = e.rays_from_camera.transpose() * rotation.toRotationMatrix();
  const Vector3d t =
      e.frame.size * (e.rays_from_camera.transpose() * (e.translation_map * columns_of(rotation)));
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!(rays[i].dot(camera_from_points * e.frame.in_plane(points[i]) + t) > 0)) return false;
  return true;
}

Solutions<RotationMinimum, kMostMinima> minima_of(const ObjectSpaceError& error,
                                                  std::size_t num_points) {
  Search search(error);
  const bool few = num_points < 6;
  search_from_eigenvectors(error, few ? 5 : 2, search);
  if (few || search.minima().empty())
    for (const Quaterniond& start : more_starts()) search.from(start);
  const auto found = search.minima();
  for (const RotationMinimum& minimum : found) search.from(other_tilt(minimum.rotation));
  auto minima = search.minima();
  std::sort(minima.begin(), minima.end(),
            [](const auto& a, const auto& b) { return a.error < b.error; });
  return minima;
}

}  // namespace

Solutions<Pose, 4> pnp(std::span<const Vector3d> points, std::span<const Vector3d> rays) {
  if (points.size() != rays.size()) throw Error("points and rays: must be equally many");
  Solutions<Pose, 4> poses;
  if (points.size() < 3) return poses;
  const auto error = object_space_error(points, rays);
  if (!error) return poses;

  for (const RotationMinimum& minimum : minima_of(*error, points.size())) {
    if (poses.full()) break;
    if (in_front(*error, minimum.rotation, points, rays))
      poses.push_back(error->camera_from_target(minimum.rotation));
  }
  return poses;
}

std::optional<Pose> pose_from_points_dlt(std::span<const Vector3d> points,
                                         std::span<const Vector3d> rays) {
  const PointSpread spread = spread_of(points);
  if (spread.shape == PointShape::point) return std::nullopt;
  Eigen::MatrixXd x(4, points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    x.col(static_cast<Eigen::Index>(i)) = (spread.in_plane(points[i]) / spread.size).homogeneous();
  const std::optional<Eigen::MatrixXd> m = projective_map(x, rays);
  if (!m) return std::nullopt;
  Eigen::Matrix<double, 3, 4> p = *m;
  const double determinant = p.leftCols<3>().determinant();
  if (determinant == 0) return std::nullopt;
  p /= std::cbrt(determinant);  // makes the left part a rotation, its sign included
  const Pose camera_from_plane(nearest_rotation(p.leftCols<3>()), spread.size * p.col(3));
  return camera_from_plane * spread.plane_from_target_pose();
}

}  // namespace tagcal
