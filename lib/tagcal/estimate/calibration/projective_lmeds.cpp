#include "tagcal/estimate/calibration/projective_lmeds.hpp"

#include <numbers>
#include <numeric>

#include "tagcal/estimate/pose/ransac.hpp"
#include "tagcal/solvers/numeric/projective_map.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector3d;

// Projective maps from a plane or from space to rays, for `ransac`.
class MapFitter {
 public:
  using Model = Eigen::Matrix<double, 3, 4>;  // of (X, Y, Z, 1); of a plane without Z

  MapFitter(std::span<const Vector3d> points, PointShape shape, std::span<const Vector3d> rays)
      : points_(points), shape_(shape), rays_(rays), all_(rays.size()), squares_(rays.size()) {
    std::iota(all_.begin(), all_.end(), 0);
  }

  std::span<const std::size_t> usable() const { return all_; }
  std::size_t sample_size() const { return shape_ == PointShape::plane ? 4 : 6; }

  void solve(std::span<const std::size_t> chosen, std::vector<Model>& models) const {
    if (const auto map = fit(chosen)) models.push_back(*map);
  }
  std::optional<Model> refit(const Model&, std::span<const std::size_t> chosen) const {
    return fit(chosen);
  }

  // Squared tangents of the angles between the rays and the mapped points, which have the order of
  // the angles; infinite from a right angle on.
  std::span<const double> squares(const Model& map) {
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      const Vector3d mapped = map * points_[i].homogeneous();
      const double along = rays_[i].dot(mapped);
      squares_[i] = along > 0 ? rays_[i].cross(mapped).squaredNorm() / (along * along)
                              : std::numeric_limits<double>::infinity();
    }
    return squares_;
  }

 private:
  std::optional<Model> fit(std::span<const std::size_t> chosen) const {
    if (chosen.size() < sample_size()) return std::nullopt;
    std::vector<Vector3d> rays;
    for (const std::size_t i : chosen) rays.push_back(rays_[i]);
    if (shape_ == PointShape::plane) {
      std::vector<Eigen::Vector2d> points;
      for (const std::size_t i : chosen) points.emplace_back(points_[i].head<2>());
      const auto h = homography(points, rays);
      if (!h) return std::nullopt;
      Model map;
      map << h->leftCols<2>(), Vector3d::Zero(), h->col(2);
      return map;
    }
    Eigen::MatrixXd points(4, static_cast<Eigen::Index>(chosen.size()));
    for (std::size_t k = 0; k < chosen.size(); ++k)
      points.col(static_cast<Eigen::Index>(k)) = points_[chosen[k]].homogeneous();
    const auto map = projective_map(points, rays);
    if (!map) return std::nullopt;
    return Model(*map);
  }

  std::span<const Vector3d> points_;
  PointShape shape_;
  std::span<const Vector3d> rays_;
  std::vector<std::size_t> all_;
  std::vector<double> squares_;
};

double angle_of(double square_of_tangent) { return std::atan(std::sqrt(square_of_tangent)); }

// Median of the squared tangents, where the noise is not known.
struct MedianOfSquares {
  double operator()(std::span<const double> squares) const {
    return median({squares.begin(), squares.end()});
  }
  // policy::kLmedsSigmas robust standard deviations, and what a lens bends.
  double inlier_square(double median) const {
    constexpr double kMedianOverSigma = 1.1774;  // numeric: sqrt(2 ln 2), a Rayleigh distribution
    const double angle =
        policy::kLmedsSigmas / kMedianOverSigma * angle_of(median) + policy::kLmedsLensRad;
    return angle < std::numbers::pi / 2 ? std::tan(angle) * std::tan(angle)
                                        : std::numeric_limits<double>::infinity();
  }
  // Wrong points move the map away from the others and make its median, by which inliers are
  // judged, large.
  bool may_end_search(double median) const {
    return angle_of(median) < policy::kLmedsGoodMedianRad;
  }
};

}  // namespace

std::optional<std::vector<std::size_t>> projective_lmeds(std::span<const Vector3d> points,
                                                         PointShape shape,
                                                         std::span<const Vector3d> rays) {
  MapFitter fitter(points, shape, rays);
  RansacOptions options{rays.size()};
  options.least_share = 0.5;       // numeric: the breakdown point of a median
  options.starts_from_all = true;  // good data need no other sample
  auto consensus = ransac(fitter, MedianOfSquares{}, options);
  if (!consensus) return std::nullopt;
  return std::move(consensus->inliers);
}

}  // namespace tagcal::internal
