#include "tagcal/solvers/plane.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tagcal/error.hpp"
#include "tagcal/solvers/numeric/inline_buffer.hpp"
#include "tagcal/solvers/numeric/plane_tilts.hpp"
#include "tagcal/solvers/numeric/small_cholesky.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Rotation whose third row is along v, from the camera to a frame that looks along v.
Matrix3d looking_along(const Vector3d& v) {
  const Vector3d z = v.normalized();
  // Frisvad's basis without its singularity (Duff et al., JCGT 2017).
  const double sign = std::copysign(1.0, z.z());
  const double a = -1 / (sign + z.z());
  const double b = z.x() * z.y() * a;
  Matrix3d r;
  r << 1 + sign * z.x() * z.x() * a, sign * b, -sign * z.x(),  //
      b, sign + z.y() * z.y() * a, -z.y(),                     //
      z.x(), z.y(), z.z();
  return r;
}

double determinant(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  return a.cross(b).dot(c);
}

// Homography of the first three points, with the weights that also map the fourth to its ray.
std::optional<Matrix3d> homography_of_four(std::span<const Vector2d> points,
                                           std::span<const Vector3d> rays) {
  const Vector3d p[4] = {points[0].homogeneous(), points[1].homogeneous(), points[2].homogeneous(),
                         points[3].homogeneous()};
  const Vector3d p23 = p[1].cross(p[2]), p31 = p[2].cross(p[0]), p12 = p[0].cross(p[1]);
  const Vector3d of_points(p23.dot(p[3]), p31.dot(p[3]), p12.dot(p[3]));
  const Vector3d of_rays(determinant(rays[1], rays[2], rays[3]),
                         determinant(rays[2], rays[0], rays[3]),
                         determinant(rays[0], rays[1], rays[3]));
  // Twice the areas of three triangles of points, and of the whole. They are rounding errors for
  // points on a line.
  const double whole = p12.dot(p[2]);
  const double size = of_points.cwiseAbs().maxCoeff();
  double largest = 0;
  for (const Vector2d& point : points) largest = std::max(largest, point.squaredNorm());
  if (!(size > 1e-12 * largest)) return std::nullopt;
  if (!(of_points.cwiseAbs().minCoeff() > 1e-9 * size) || !(std::abs(whole) > 1e-9 * size))
    return std::nullopt;
  // With P = [p1 p2 p3] and Q = [r1 r2 r3]: p4 = P lambda / whole, r4 = Q mu / |Q|. The weights
  // mu / lambda and the one of the fourth must have one sign for all points to lie in front.
  const double rays_whole = determinant(rays[0], rays[1], rays[2]);
  const Vector3d weight = of_rays.cwiseQuotient(of_points) * (whole / rays_whole);
  if (!(weight.minCoeff() > 0) || !weight.allFinite()) return std::nullopt;
  Matrix3d h = (weight.x() / whole) * rays[0] * p23.transpose();
  h += (weight.y() / whole) * rays[1] * p31.transpose();
  h += (weight.z() / whole) * rays[2] * p12.transpose();
  return h;
}

// Moves points to their centre and scales them to an RMS distance of sqrt(2).
class Normalisation {
 public:
  explicit Normalisation(std::span<const Vector2d> points) {
    const auto count = static_cast<double>(points.size());
    Vector2d sum = Vector2d::Zero();
    double square = 0;
    for (const Vector2d& p : points) {
      const Vector2d offset = p - points.front();
      sum += offset;
      square += offset.squaredNorm();
    }
    centre_ = points.front() + sum / count;
    scale_ = std::sqrt(2 * count / (square - sum.squaredNorm() / count));
  }

  bool valid() const { return std::isfinite(scale_); }
  Vector2d operator()(const Vector2d& point) const { return scale_ * (point - centre_); }

  Matrix3d matrix() const {
    Matrix3d m;
    m << scale_, 0, -scale_ * centre_.x(), 0, scale_, -scale_ * centre_.y(), 0, 0, 1;
    return m;
  }
  Matrix3d inverse() const {
    Matrix3d m;
    m << 1 / scale_, 0, centre_.x(), 0, 1 / scale_, centre_.y(), 0, 0, 1;
    return m;
  }

 private:
  Vector2d centre_;
  double scale_;
};

// Rotation after which every ray has a clearly positive z; the identity if that holds already, as
// for a pinhole.
Matrix3d sight_frame(std::span<const Vector3d> rays) {
  bool in_front = true;
  for (const Vector3d& ray : rays)
    in_front &= ray.z() > 0.2 * (std::abs(ray.x()) + std::abs(ray.y()));
  if (in_front) return Matrix3d::Identity();
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& ray : rays) mean += ray.normalized();
  return looking_along(mean);
}

// A'A and A'b of the rows of x_i (h3 . X_i) = h1 . X_i, y_i (h3 . X_i) = h2 . X_i with h33 = 1,
// unknowns h11 h12 h13 h21 h22 h23 h31 h32: sums of products of X_i = (X, Y, 1), weighted with 1,
// x, y and x^2 + y^2.
class TransformationSums {
 public:
  void add(const Vector2d& point, const Vector2d& image) {
    const double products[6] = {point.x() * point.x(),
                                point.x() * point.y(),
                                point.x(),
                                point.y() * point.y(),
                                point.y(),
                                1};
    const double square = image.squaredNorm();
    for (int k = 0; k < 6; ++k) {
      plain_[k] += products[k];
      x_[k] += image.x() * products[k];
      y_[k] += image.y() * products[k];
      square_[k] += square * products[k];
    }
  }

  std::optional<Matrix3d> solve() const {
    constexpr int kIndex[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    Eigen::Matrix<double, 8, 8> a = Eigen::Matrix<double, 8, 8>::Zero();
    Eigen::Matrix<double, 8, 1> b;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        a(i, j) = a(3 + i, 3 + j) = plain_[kIndex[i][j]];
        if (j == 2) continue;
        a(i, 6 + j) = -x_[kIndex[i][j]];
        a(3 + i, 6 + j) = -y_[kIndex[i][j]];
        if (i < 2) a(6 + i, 6 + j) = square_[kIndex[i][j]];
      }
      b[i] = x_[kIndex[i][2]];
      b[3 + i] = y_[kIndex[i][2]];
      if (i < 2) b[6 + i] = -square_[kIndex[i][2]];
    }
    SmallCholesky<8> cholesky;
    if (!cholesky.compute(a)) return std::nullopt;
    const Eigen::Matrix<double, 8, 1> h = cholesky.solve(b);
    Matrix3d result;
    result << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1;
    return result;
  }

 private:
  double plain_[6] = {}, x_[6] = {}, y_[6] = {}, square_[6] = {};
};

std::optional<Matrix3d> homography_of_many(std::span<const Vector2d> points,
                                           std::span<const Vector3d> rays) {
  const std::size_t n = points.size();
  const Matrix3d sight_from_camera = sight_frame(rays);
  InlineBuffer<Vector2d, 32> images(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3d ray = sight_from_camera * rays[i];
    if (!(ray.z() > 0))
      return std::nullopt;  // the points span 180 degrees or more: no plane in front
    images[i] = ray.hnormalized();
  }
  const Normalisation of_points(points), of_images(images.span());
  if (!of_points.valid() || !of_images.valid()) return std::nullopt;
  TransformationSums sums;
  for (std::size_t i = 0; i < n; ++i) sums.add(of_points(points[i]), of_images(images[i]));
  const std::optional<Matrix3d> h = sums.solve();
  if (!h) return std::nullopt;
  return Matrix3d(sight_from_camera.transpose() * of_images.inverse() * *h * of_points.matrix());
}

}  // namespace

std::optional<Matrix3d> homography(std::span<const Vector2d> points,
                                   std::span<const Vector3d> rays) {
  if (points.size() != rays.size()) throw Error("points and rays: must be equally many");
  if (points.size() < 4) return std::nullopt;
  const std::optional<Matrix3d> h =
      points.size() == 4 ? homography_of_four(points, rays) : homography_of_many(points, rays);
  if (!h || !h->allFinite()) return std::nullopt;
  return h;
}

std::optional<PlaneTilts> internal::ippe_tilts(const Matrix3d& camera_from_plane) {
  const Vector3d origin = camera_from_plane.col(2);
  const double size = origin.norm();
  const Matrix3d sight_from_camera = looking_along(origin);
  // Image of the plane about its origin, seen along the ray to it: A = (upper left of R) / depth.
  const Eigen::Matrix2d a = sight_from_camera.topRows<2>() * camera_from_plane.leftCols<2>() / size;
  const double half_trace = a.squaredNorm() / 2, det = a.determinant();
  // half_trace^2 - det^2 would be the same, but loses half of the digits if the plane faces the
  // camera, and the tilt half of the rest.
  const double stretch = (a.col(0).squaredNorm() - a.col(1).squaredNorm()) / 2;
  const double shear = a.col(0).dot(a.col(1));
  const double gap = std::sqrt(stretch * stretch + shear * shear);
  const double inverse_depth = std::sqrt(half_trace + gap);  // the larger singular value
  if (!(std::abs(det) > 0) || !std::isfinite(1 / inverse_depth) || !std::isfinite(size))
    return std::nullopt;
  const Eigen::Matrix2d upper = a / inverse_depth;
  // The third row of R, up to its sign: b b' = 1 - A'A, of rank one. It is zero if the plane
  // faces the camera.
  const double bb00 = std::max(0.0, 1 - upper.col(0).squaredNorm());
  const double bb11 = std::max(0.0, 1 - upper.col(1).squaredNorm());
  const double bb01 = -upper.col(0).dot(upper.col(1));
  Vector2d b = Vector2d::Zero();
  if (bb00 >= bb11 && bb00 > 0) b = Vector2d(bb00, bb01) / std::sqrt(bb00);
  if (bb11 > bb00) b = Vector2d(bb01, bb11) / std::sqrt(bb11);
  PlaneTilts tilts;
  tilts.translation = origin / (size * inverse_depth);
  for (const int k : {0, 1}) {
    Matrix3d r;
    r.topLeftCorner<2, 2>() = upper;
    r.bottomLeftCorner<1, 2>() = (k == 0 ? b : Vector2d(-b)).transpose();
    r.col(2) = r.col(0).cross(r.col(1));
    tilts.rotation[k].noalias() = sight_from_camera.transpose() * r;
  }
  return tilts;
}

Solutions<Pose, 2> ippe(const Matrix3d& camera_from_plane) {
  Solutions<Pose, 2> poses;
  if (const std::optional<PlaneTilts> tilts = ippe_tilts(camera_from_plane))
    for (const Matrix3d& rotation : tilts->rotation)
      poses.push_back({Eigen::Quaterniond(rotation), tilts->translation});
  return poses;
}

std::optional<double> focal_ratio_from_homographies(std::span<const Matrix3d> homographies) {
  // Each of the two constraints of each view is w a + b = 0 with w = 1 / ratio^2.
  double aa = 0, ab = 0;
  for (const Matrix3d& h : homographies) {
    const Matrix3d g = h / std::sqrt(h.col(0).norm() * h.col(1).norm());
    const double a1 = g(0, 0) * g(0, 1) + g(1, 0) * g(1, 1), b1 = g(2, 0) * g(2, 1);
    const double a2 = g.col(0).head<2>().squaredNorm() - g.col(1).head<2>().squaredNorm();
    const double b2 = g(2, 0) * g(2, 0) - g(2, 1) * g(2, 1);
    aa += a1 * a1 + a2 * a2;
    ab += a1 * b1 + a2 * b2;
  }
  const double w = -ab / aa;
  if (!(w > 1e-8 && w < 1e8)) return std::nullopt;
  return 1 / std::sqrt(w);
}

Pose pose_from_homography(const Matrix3d& camera_from_plane) {
  const Vector3d h1 = camera_from_plane.col(0), h2 = camera_from_plane.col(1);
  const double scale = 2 / (h1.norm() + h2.norm());
  // Turns the columns symmetrically until they are orthogonal.
  const Vector3d sum = h1.normalized() + h2.normalized(),
                 difference = h1.normalized() - h2.normalized();
  const Vector3d a = sum.normalized(), b = difference.normalized();
  Matrix3d r;
  r << (a + b) * std::numbers::sqrt2 / 2, (a - b) * std::numbers::sqrt2 / 2, b.cross(a);
  return {Eigen::Quaterniond(r), scale * camera_from_plane.col(2)};
}

std::optional<PoseAndFocal> plane_pose_and_focal(std::span<const Vector2d> points,
                                                 std::span<const Vector2d> pixels_from_centre) {
  const std::size_t n = points.size();
  double square = 0;
  for (const Vector2d& p : pixels_from_centre) square += p.squaredNorm();
  const double unit = std::sqrt(square / static_cast<double>(n));  // makes rays of about 45 degrees
  if (!(unit > 0) || !std::isfinite(unit)) return std::nullopt;
  InlineBuffer<Vector3d, 16> rays(n);
  for (std::size_t i = 0; i < n; ++i) rays[i] = (pixels_from_centre[i] / unit).homogeneous();
  std::optional<Matrix3d> h = homography(points, rays.span());
  if (!h) return std::nullopt;
  const std::optional<double> ratio = focal_ratio_from_homographies({&*h, 1});
  if (!ratio) return std::nullopt;
  h->topRows<2>() /= *ratio;
  return PoseAndFocal{pose_from_homography(*h), *ratio * unit};
}

}  // namespace tagcal
