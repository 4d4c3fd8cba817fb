#include "tagcal/detect/board_search/corner_error.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>

#include "tagcal/detect/board_search/panel_lens.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/scene/board.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Terms of the surface through neighbours, of second order. Source: with a plane what a lens of
// another kind leaves between tags of 300 px counted as scatter (0.014 px of true 0.0046).
constexpr int kSurfaceTerms = 6;
// Corners of other tags from which a residual is predicted. Source: 12 and 20 give the same within
// a quarter.
constexpr std::size_t kScatterNeighbours = 16;
// The prediction's largest share of the variance of one residual. It has a third of it amid its
// neighbours and one beside them. With 0.4 boards of 6 tags have too few corners left to tell their
// scatter; with this they and large tags scatter by 0.052, 0.091, 0.0064 px of true 0.055, 0.107,
// 0.0046.
constexpr double kMostShare = 1.5;         // numeric: farther out a surface is extrapolated
constexpr std::size_t kMostViews = 60;     // evenly chosen, as a limit of work
const double kMedian = 2 * std::log(2.0);  // of a chi-square with two degrees of freedom

// A corner with its residual under the lens of its panel.
struct PanelResidual {
  int tag_id = 0;
  Vector2d on_panel;
  Vector2d residual_px;
  Matrix2d covariance_px2;
};

// A corner's residual beside that of its neighbours.
struct Scatter {
  Vector2d off_px;
  Matrix2d claimed_px2;  // of `off_px`, by the claims of all that enter
  double share = 1;      // of the variance that all corners have beyond their claims

  double square(double variance) const {
    const Matrix2d all = claimed_px2 + share * variance * Matrix2d::Identity();
    return off_px.dot(all.inverse() * off_px);
  }
};

using PointsById = std::map<CornerId, Vector3d>;

// Residuals of a board's corners in a view; empty if they do not determine lens and pose.
std::vector<PanelResidual> residuals_of(const View& view, const ImageSize& size,
                                        const PointsById& points) {
  std::vector<PanelResidual> result;
  std::vector<PanelCorner> corners;
  for (const Observation& seen : view.observations) {
    const auto point = points.find(seen.id);
    if (point == points.end() || !seen.covariance_px2 || point->second.z() != 0) continue;
    const Vector2d place = point->second.head<2>();
    corners.push_back({place, seen.pixel, std::sqrt(seen.covariance_px2->trace() / 2)});
    result.push_back({seen.id.tag_id, place, seen.pixel, *seen.covariance_px2});
  }
  const auto lens = lens_of_panel(corners, size);
  if (!lens) return {};
  for (PanelResidual& corner : result) {
    const auto pixel = lens->pixel(corner.on_panel);
    if (!pixel) return {};
    corner.residual_px -= *pixel;
  }
  return result;
}

// The residual of a corner beside the surface of second order through those of the nearest corners
// of other tags.
std::optional<Scatter> scatter_of(const PanelResidual& corner,
                                  const std::vector<PanelResidual>& corners) {
  std::vector<const PanelResidual*> near;
  for (const PanelResidual& other : corners)
    if (other.tag_id != corner.tag_id) near.push_back(&other);
  if (near.size() < kScatterNeighbours) return std::nullopt;
  const auto distance = [&](const PanelResidual* other) {
    return (other->on_panel - corner.on_panel).squaredNorm();
  };
  std::ranges::nth_element(near, near.begin() + kScatterNeighbours, {}, distance);
  near.resize(kScatterNeighbours);
  const double unit = std::sqrt(distance(near.back()));
  using Terms = Eigen::Matrix<double, kSurfaceTerms, 1>;
  const auto terms = [&](const PanelResidual* other) {
    const Vector2d at = (other->on_panel - corner.on_panel) / unit;
    return Terms{1, at.x(), at.y(), at.x() * at.x(), at.x() * at.y(), at.y() * at.y()};
  };
  Eigen::Matrix<double, kSurfaceTerms, kSurfaceTerms> normal =
      Eigen::Matrix<double, kSurfaceTerms, kSurfaceTerms>::Zero();
  for (const PanelResidual* other : near) normal += terms(other) * terms(other).transpose();
  const Terms at_corner = normal.ldlt().solve(Terms::Unit(0));
  Scatter scatter{corner.residual_px, corner.covariance_px2};
  for (const PanelResidual* other : near) {
    const double weight = at_corner.dot(terms(other));
    scatter.off_px -= weight * other->residual_px;
    scatter.claimed_px2 += weight * weight * other->covariance_px2;
    scatter.share += weight * weight;
  }
  const bool is_inside = scatter.share < 1 + kMostShare;
  return is_inside && scatter.off_px.allFinite() ? std::optional(scatter) : std::nullopt;
}

std::vector<Scatter> scatters_of(const std::vector<ViewOfSize>& views,
                                 const std::vector<PlacedBoard>& boards) {
  std::vector<Scatter> scatters;
  const std::size_t step = 1 + views.size() / kMostViews;
  for (const PlacedBoard& placed : boards) {
    PointsById points;
    for (const TargetPoint& point : target_points(placed.board))
      points.emplace(point.id, point.position);
    for (std::size_t i = 0; i < views.size(); i += step) {
      const std::vector<PanelResidual> corners =
          residuals_of(*views[i].view, views[i].size, points);
      for (const PanelResidual& corner : corners)
        if (const auto scatter = scatter_of(corner, corners)) scatters.push_back(*scatter);
    }
  }
  return scatters;
}

// The variance per coordinate beyond the claims, px^2, by the median of the squares over what is
// claimed; zero if more than half of them by chance exceed it.
double variance_beyond(std::span<const Scatter> scatters) {
  const auto num_above = [&](double variance) {
    return static_cast<double>(std::ranges::count_if(
        scatters, [&](const Scatter& one) { return one.square(variance) > kMedian; }));
  };
  const auto half = static_cast<double>(scatters.size()) / 2;
  if (num_above(0) <= half + policy::kOutlierSds * std::sqrt(half / 2)) return 0;
  double low = 0, high = 1e-6;  // numeric: px^2, below any corner's variance
  while (num_above(high) > half) high *= 4;
  while (high - low > 1e-3 * high) {  // numeric: precision of the bisection
    const double middle = (low + high) / 2;
    (num_above(middle) > half ? low : high) = middle;
  }
  return high;
}

}  // namespace

void widen_covariance(Observation& seen, double error_px) {
  if (seen.covariance_px2) seen.covariance_px2->diagonal().array() += error_px * error_px;
}

void widen_covariances(View& view, double error_px) {
  for (Observation& seen : view.observations) widen_covariance(seen, error_px);
}

double corner_error(const std::vector<ViewOfSize>& views, const std::vector<PlacedBoard>& boards) {
  const std::vector<Scatter> scatters = scatters_of(views, boards);
  return scatters.empty() ? 0 : std::sqrt(variance_beyond(scatters));
}

double add_corner_error(const std::vector<ViewOfSize>& views,
                        const std::vector<PlacedBoard>& boards) {
  const double error = corner_error(views, boards);
  for (const ViewOfSize& one : views) widen_covariances(*one.view, error);
  return error;
}

ScatterNees scatter_nees(const std::vector<ViewOfSize>& views,
                         const std::vector<PlacedBoard>& boards) {
  ScatterNees result;
  for (const Scatter& scatter : scatters_of(views, boards)) {
    ++result.num_corners;
    result.sum += scatter.square(0) / 2;
  }
  return result;
}

}  // namespace tagcal::internal
