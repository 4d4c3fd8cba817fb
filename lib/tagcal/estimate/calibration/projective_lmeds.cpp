#include "tagcal/estimate/calibration/projective_lmeds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "tagcal/random.hpp"
#include "tagcal/solvers/numeric/point_spread.hpp"
#include "tagcal/solvers/numeric/projective_map.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;

// 150 samples of four hold one without a wrong corner with p > 0.9999 at 50 % wrong corners.
constexpr int kNumSamples = 150;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Squared tangents stand for angles, whose order they keep: infinite from a right angle on.
double square_of_tangent(const Vector3d& ray, const Vector3d& mapped) {
  const double along = ray.dot(mapped);
  return along > 0 ? ray.cross(mapped).squaredNorm() / (along * along) : kInfinity;
}

double angle_of(double square_of_tangent) { return std::atan(std::sqrt(square_of_tangent)); }

// Of every so many-th value.
double median(std::span<const double> all, std::size_t stride, std::vector<double>& values) {
  values.clear();
  for (std::size_t i = 0; i < all.size(); i += stride) values.push_back(all[i]);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Within 6 robust standard deviations, and what a lens may bend beside it.
double tolerance_of(double median_square) {
  constexpr double kMedianOverSigma = 1.1774;  // of a Rayleigh distribution
  const double angle = 6 / kMedianOverSigma * angle_of(median_square) + 1e-3;
  return angle < std::numbers::pi / 2 ? std::tan(angle) * std::tan(angle) : kInfinity;
}

// A plane to rays; what the search needs to know of it.
class PlaneMap {
 public:
  static constexpr std::size_t kSampleSize = 4;

  PlaneMap(std::span<const Vector3d> points, std::span<const Vector3d> rays) : rays_(rays) {
    for (const Vector3d& p : points) points_.push_back(p.head<2>());
  }

  // Squared tangents of the angles between each ray and where the map of the chosen puts its point.
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

// Space to rays.
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
class Search {
 public:
  Search(const Map& map, std::size_t n) : map_(map), squares_(n) {}

  std::optional<Consensus> run() {
    const std::size_t n = squares_.size();
    if (n < Map::kSampleSize) return std::nullopt;
    // Good data end here: one map fits nearly all, as the median of some shows. Wrong ones would
    // bend it away from the others.
    constexpr std::size_t kEnough = 36;
    std::vector<std::size_t> all(n);
    std::iota(all.begin(), all.end(), 0);
    consider(all, (n + kEnough - 1) / kEnough);
    const std::size_t most =
        !best_.empty() && angle_of(best_median_) < 0.01 ? agreeing().size() : 0;
    if (most < n) {
      best_median_ = kInfinity;
      consider(all);
    }
    Random random(n);
    std::vector<std::size_t> sample;
    for (int i = 0; i < (20 * most >= 19 * n ? 0 : kNumSamples); ++i) {
      draw(random, sample);
      consider(sample);
    }
    if (best_.empty()) return std::nullopt;
    for (int i = 0; i < 3 && most < n; ++i) consider(agreeing());
    Consensus consensus{std::vector<std::uint8_t>(n, 0), angle_of(best_median_)};
    for (const std::size_t i : agreeing()) consensus.inlier[i] = 1;
    return consensus;
  }

 private:
  // The map of the chosen, by the median of every so many-th square.
  void consider(const std::vector<std::size_t>& chosen, std::size_t stride = 1) {
    if (!map_.find(chosen, squares_)) return;
    const double m = median(squares_, stride, median_buffer_);
    if (!(m < best_median_)) return;
    best_median_ = m;
    best_ = squares_;
  }

  std::vector<std::size_t> agreeing() const {
    const double tolerance = tolerance_of(best_median_);
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < best_.size(); ++i)
      if (best_[i] <= tolerance) chosen.push_back(i);
    return chosen;
  }

  void draw(Random& random, std::vector<std::size_t>& sample) const {
    sample.clear();
    while (sample.size() < Map::kSampleSize) {
      const std::size_t i = random.index(squares_.size());
      if (std::find(sample.begin(), sample.end(), i) == sample.end()) sample.push_back(i);
    }
  }

  const Map& map_;
  std::vector<double> squares_;  // of the map at hand
  std::vector<double> median_buffer_;
  std::vector<double> best_;
  double best_median_ = kInfinity;
};

}  // namespace

std::optional<Consensus> find_consensus(std::span<const Vector3d> points, PointShape shape,
                                        std::span<const Vector3d> rays) {
  if (shape == PointShape::plane) return Search(PlaneMap(points, rays), rays.size()).run();
  return Search(SpaceMap(points, rays), rays.size()).run();
}

}  // namespace tagcal::internal
