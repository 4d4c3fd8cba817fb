#include "tagcal/estimate/calibration/projective_lmeds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/random.hpp"
#include "tagcal/solvers/numeric/point_spread.hpp"
#include "tagcal/solvers/numeric/projective_map.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The squared tangent of the angle between two directions, which has the order of the angle;
// infinite from a right angle on.
double square_of_tangent(const Vector3d& ray, const Vector3d& mapped) {
  const double along = ray.dot(mapped);
  return along > 0 ? ray.cross(mapped).squaredNorm() / (along * along) : kInfinity;
}

double angle_of(double square_of_tangent) { return std::atan(std::sqrt(square_of_tangent)); }

// Median of every `stride`-th value; `values` is a buffer.
double median(std::span<const double> all, std::size_t stride, std::vector<double>& values) {
  values.clear();
  for (std::size_t i = 0; i < all.size(); i += stride) values.push_back(all[i]);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Squared tangent of the largest angle of an inlier: policy::kLmedsSigmas robust standard
// deviations, and what a lens bends.
double inlier_bound(double median_square) {
  constexpr double kMedianOverSigma = 1.1774;  // numeric: sqrt(2 ln 2), a Rayleigh distribution
  const double angle =
      policy::kLmedsSigmas / kMedianOverSigma * angle_of(median_square) + policy::kLmedsLensRad;
  return angle < std::numbers::pi / 2 ? std::tan(angle) * std::tan(angle) : kInfinity;
}

// Projective maps from a plane to rays.
class PlaneMap {
 public:
  static constexpr std::size_t kSampleSize = 4;

  PlaneMap(std::span<const Vector3d> points, std::span<const Vector3d> rays) : rays_(rays) {
    for (const Vector3d& p : points) points_.push_back(p.head<2>());
  }

  // Fits the map to the chosen points. Returns the squared tangents of the angles between all rays
  // and their mapped points; false if the points determine no map.
  bool find(std::span<const std::size_t> chosen, std::vector<double>& squares) const {
    std::vector<Vector2d> points;
    std::vector<Vector3d> rays;
    for (const std::size_t i : chosen) {
      points.push_back(points_[i]);
      rays.push_back(rays_[i]);
    }
    const auto h = homography(points, rays);
    if (!h) return false;
    for (std::size_t i = 0; i < rays_.size(); ++i)
      squares[i] = square_of_tangent(rays_[i], *h * points_[i].homogeneous());
    return true;
  }

 private:
  std::vector<Vector2d> points_;
  std::span<const Vector3d> rays_;
};

// Projective maps from space to rays.
class SpaceMap {
 public:
  static constexpr std::size_t kSampleSize = 6;

  SpaceMap(std::span<const Vector3d> points, std::span<const Vector3d> rays)
      : points_(points), rays_(rays) {}

  bool find(std::span<const std::size_t> chosen, std::vector<double>& squares) const {
    MatrixXd points(4, static_cast<Eigen::Index>(chosen.size()));
    std::vector<Vector3d> rays;
    for (const std::size_t i : chosen) {
      points.col(static_cast<Eigen::Index>(rays.size())) = points_[i].homogeneous();
      rays.push_back(rays_[i]);
    }
    const auto map = projective_map(points, rays);
    if (!map) return false;
    for (std::size_t i = 0; i < rays_.size(); ++i)
      squares[i] = square_of_tangent(rays_[i], *map * points_[i].homogeneous());
    return true;
  }

 private:
  std::span<const Vector3d> points_;
  std::span<const Vector3d> rays_;
};

template <typename Map>
class LmedsSearch {
 public:
  LmedsSearch(const Map& map, std::size_t n) : map_(map), squares_(n) {}

  std::optional<Consensus> run() {
    const std::size_t n = squares_.size();
    if (n < Map::kSampleSize) return std::nullopt;
    // One map of all points suffices for good data: its median angle is small, because wrong points
    // would move the map away from the others.
    constexpr std::size_t kEnough = 36;  // a limit of work: points of this median
    std::vector<std::size_t> all(n);
    std::iota(all.begin(), all.end(), 0);
    try_map(all, (n + kEnough - 1) / kEnough);
    const bool is_good = !best_.empty() && angle_of(best_median_) < policy::kLmedsGoodMedianRad;
    const std::size_t num_inliers = is_good ? inliers().size() : 0;
    if (num_inliers < n) {
      best_median_ = kInfinity;
      try_map(all);
    }
    Random random(n);
    std::vector<std::size_t> sample;
    const bool needs_samples = policy::is_below(num_inliers, policy::kLmedsGoodInliers, n);
    for (int i = 0; i < (needs_samples ? policy::kLmedsSamples : 0); ++i) {
      draw_sample(random, sample);
      try_map(sample);
    }
    if (best_.empty()) return std::nullopt;
    for (int i = 0; i < 3 && num_inliers < n; ++i) try_map(inliers());
    Consensus consensus{std::vector<std::uint8_t>(n, 0), angle_of(best_median_)};
    for (const std::size_t i : inliers()) consensus.inlier[i] = 1;
    return consensus;
  }

 private:
  // Keeps the map of the chosen points if its median (of every `stride`-th square) is the lowest.
  void try_map(const std::vector<std::size_t>& chosen, std::size_t stride = 1) {
    if (!map_.find(chosen, squares_)) return;
    const double m = median(squares_, stride, median_buffer_);
    if (!(m < best_median_)) return;
    best_median_ = m;
    best_ = squares_;
  }

  std::vector<std::size_t> inliers() const {
    const double bound = inlier_bound(best_median_);
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < best_.size(); ++i)
      if (best_[i] <= bound) indices.push_back(i);
    return indices;
  }

  void draw_sample(Random& random, std::vector<std::size_t>& sample) const {
    sample.clear();
    while (sample.size() < Map::kSampleSize) {
      const std::size_t i = random.index(squares_.size());
      if (std::find(sample.begin(), sample.end(), i) == sample.end()) sample.push_back(i);
    }
  }

  const Map& map_;
  std::vector<double> squares_;  // of the current map
  std::vector<double> median_buffer_;
  std::vector<double> best_;
  double best_median_ = kInfinity;
};

}  // namespace

std::optional<Consensus> projective_lmeds(std::span<const Vector3d> points, PointShape shape,
                                          std::span<const Vector3d> rays) {
  if (shape == PointShape::plane) return LmedsSearch(PlaneMap(points, rays), rays.size()).run();
  return LmedsSearch(SpaceMap(points, rays), rays.size()).run();
}

}  // namespace tagcal::internal
