#include "tagcal/detect/board_search/panel_lens.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

using namespace policy;

// Parameters: logarithms of f and of fy / fx, principal point, k1..k4, pose (a rotation and a
// translation in the camera's frame).
constexpr int kNumLens = 8;
constexpr int kCount = kNumLens + 6;
using Step = Eigen::Matrix<double, kCount, 1>;
using System = Eigen::Matrix<double, kCount, kCount>;

// Radius of the middle of the picture, in longer sides: with every focal length it shows less than
// half a sphere.
constexpr double kInner = 0.3;      // numeric: half a field of view of 57 degrees at most
constexpr std::size_t kStarts = 2;  // best ones that are iterated
// Spread of residuals, in sds, with which a lens explains the corners: no other start ends better.
constexpr double kExplained = 1.2;     // numeric: limit of work, a spread of 1 and its scatter
constexpr int kMaxSteps = 40;          // Gauss-Newton, as a limit of work
constexpr double kLeastSpread = 0.1;   // numeric: of residuals, in sds; none is an outlier below it
constexpr double kSmallGain = 1e-4;    // numeric: relative gain of the cost that ends the iteration
constexpr double kMaxLogFocal = 0.3;   // numeric: largest step of the logarithm of f
constexpr double kMaxLogAspect = 0.1;  // numeric: largest step of the logarithm of fy / fx
constexpr double kFirstDamping = 1e-3;      // numeric: Levenberg-Marquardt's start
constexpr double kLeastDamping = 1e-9;      // numeric: Levenberg-Marquardt's bound
constexpr double kLessDamping = 0.1;        // numeric: factor after a good step
constexpr double kRayleighMedian = 1.1774;  // numeric: median, in sds per coordinate: sqrt(2 log 2)

struct State {
  double f = 1;
  double aspect = 1;  // fy / fx
  Vector2d centre = Vector2d::Zero();
  std::array<double, 4> k{};
  Pose pose;

  Fisheye lens() const {
    return Fisheye({f, f * aspect, centre.x(), centre.y(), k[0], k[1], k[2], k[3]});
  }

  State moved(const Step& step) const {
    State next = *this;
    next.f *= std::exp(std::clamp(step[0], -kMaxLogFocal, kMaxLogFocal));
    next.aspect *= std::exp(std::clamp(step[1], -kMaxLogAspect, kMaxLogAspect));
    next.centre += step.segment<2>(2);
    for (std::size_t i = 0; i < 4; ++i) next.k[i] += step[4 + static_cast<Eigen::Index>(i)];
    const Vector3d turn = step.segment<3>(kNumLens), shift = step.segment<3>(kNumLens + 3);
    next.pose = Pose(exp_rotation(turn) * pose.rotation(), pose.translation() + shift);
    return next;
  }
};

class PanelFit {
 public:
  PanelFit(std::span<const PanelCorner> corners, const ImageSize& size)
      : corners_(corners), side_(std::max(size.width, size.height)), centre_(image_centre(size)) {
    for (const PanelCorner& corner : corners) middle_ += corner.on_panel;
    middle_ /= static_cast<double>(corners.size());
    double sum = 0;
    for (const PanelCorner& corner : corners) sum += (corner.on_panel - middle_).norm();
    unit_ = sum / static_cast<double>(corners.size());
  }

  // A point of the plane from the middle of all corners, in units of their mean distance from it.
  Vector2d on_plane(const Vector2d& on_panel) const { return (on_panel - middle_) / unit_; }
  const Vector2d& middle() const { return middle_; }
  double unit() const { return unit_; }

  std::optional<State> start(double focal) const {
    State state;
    state.f = focal * side_;
    state.centre = centre_;
    const Fisheye lens = state.lens();
    auto h = rays_from_plane(lens, std::numeric_limits<double>::infinity());
    // Errors of a rough lens may move directions along the panel's plane behind it.
    if (!h) h = rays_from_plane(lens, kInner * side_);
    if (!h) return std::nullopt;
    state.pose = pose_from_homography(*h);
    return state;
  }

  State start(const PanelLens& known) const {
    const auto& p = std::get<Fisheye>(known.camera.lens).parameters();
    const Pose& pose = known.camera_from_panel;
    const Vector3d middle(middle_.x(), middle_.y(), 0);
    return {p[0],
            p[1] / p[0],
            {p[2], p[3]},
            {p[4], p[5], p[6], p[7]},
            Pose(pose.rotation(), (pose * middle) / unit_)};
  }

  // See PanelLens::nearby.
  std::vector<Lens> nearby(const State& state) const {
    System system;
    Step right;
    linearise(state, spread(distances(state)), system, right);
    const System covariance = system.ldlt().solve(System::Identity());
    const Eigen::Matrix<double, kNumLens, kNumLens> sides =
        covariance.topLeftCorner<kNumLens, kNumLens>().llt().matrixL();
    std::vector<Lens> lenses;
    for (int i = 0; i < kNumLens; ++i) {
      Step step = Step::Zero();
      step.head<kNumLens>() = PanelLens::kNearby * sides.col(i);
      lenses.emplace_back(state.moved(step).lens());
    }
    return lenses;
  }

  // Distances of the corners from their projections, in their standard deviations; empty if one is
  // outside the lens' domain.
  std::vector<double> distances(const State& state) const {
    const Fisheye lens = state.lens();
    std::vector<double> result;
    for (const PanelCorner& corner : corners_) {
      const auto pixel = lens.project(state.pose * in_plane(corner));
      if (!pixel) return {};
      result.push_back((*pixel - corner.pixel).norm() / corner.sd_px);
    }
    return result;
  }

  // Robust standard deviation per coordinate; the distances have a Rayleigh distribution.
  static double spread(const std::vector<double>& distances) {
    return std::max(kLeastSpread, median(distances) / kRayleighMedian);
  }

  std::optional<State> converge(State state) const {
    double damping = kFirstDamping;
    std::vector<double> off = distances(state);
    if (off.empty()) return std::nullopt;
    for (int i = 0; i < kMaxSteps; ++i) {
      const double width = spread(off);
      System system;
      Step right;
      linearise(state, width, system, right);
      const double before = cost(state, off, width);
      double gain = 0;
      while (damping < 1e8) {
        System damped = system;
        damped.diagonal() *= 1 + damping;
        const Step step = damped.ldlt().solve(right);
        if (!step.allFinite()) return std::nullopt;
        const State next = state.moved(step);
        std::vector<double> next_off = distances(next);
        gain = next_off.empty() ? -1 : 1 - cost(next, next_off, width) / before;
        if (gain >= 0) {
          state = next;
          off = std::move(next_off);
          damping = std::max(kLeastDamping, kLessDamping * damping);
          break;
        }
        damping *= 10;
      }
      if (gain < kSmallGain) break;
    }
    return state;
  }

 private:
  // From the corners that are nearer to the picture's middle than `radius_px`.
  std::optional<Eigen::Matrix3d> rays_from_plane(const Fisheye& lens, double radius_px) const {
    std::vector<Vector2d> points;
    std::vector<Vector3d> rays;
    for (const PanelCorner& corner : corners_) {
      if ((corner.pixel - centre_).norm() > radius_px) continue;
      const auto ray = lens.ray_in_camera(corner.pixel);
      if (!ray) return std::nullopt;
      points.push_back(on_plane(corner.on_panel));
      rays.push_back(ray->direction);
    }
    return points.size() < 4 ? std::nullopt : homography(points, rays);
  }

  Vector3d in_plane(const PanelCorner& corner) const {
    const Vector2d at = on_plane(corner.on_panel);
    return {at.x(), at.y(), 0};
  }

  // Deviation from the prior, in its standard deviations.
  Step prior_residual(const State& state) const {
    Step result = Step::Zero();
    result[0] = std::log(state.f / (side_ / 2)) / kPanelLogFocalSd;
    result[1] = std::log(state.aspect) / kPanelLogAspectSd;
    result.segment<2>(2) = (state.centre - centre_) / (kPanelCentreSd * side_);
    for (std::size_t i = 0; i < 4; ++i)
      result[4 + static_cast<Eigen::Index>(i)] = state.k[i] / kPanelTermSd;
    return result;
  }

  // 1 / sd of the prior; zero for the pose.
  Step prior_weights() const {
    Step result = Step::Zero();
    result[0] = 1 / kPanelLogFocalSd;
    result[1] = 1 / kPanelLogAspectSd;
    result.segment<2>(2).setConstant(1 / (kPanelCentreSd * side_));
    result.segment<4>(4).setConstant(1 / kPanelTermSd);
    return result;
  }

  double cost(const State& state, const std::vector<double>& off, double width) const {
    double sum = prior_residual(state).squaredNorm();
    for (const double r : off)
      sum += kPanelTailSpreads * kPanelTailSpreads *
             std::log1p(std::pow(r / (kPanelTailSpreads * width), 2));
    return sum;
  }

  void linearise(const State& state, double width, System& system, Step& right) const {
    const Step weights = prior_weights();
    system = weights.cwiseAbs2().asDiagonal();
    right = -weights.cwiseProduct(prior_residual(state));
    const Fisheye lens = state.lens();
    for (const PanelCorner& corner : corners_) {
      PointJacobian by_point;
      Fisheye::ParameterJacobian by_parameters;
      const Vector3d turned = state.pose.rotation() * in_plane(corner);
      const auto pixel = lens.project(turned + state.pose.translation(), &by_point, &by_parameters);
      if (!pixel) continue;
      Eigen::Matrix<double, 2, kCount> by;
      by.col(1) = state.f * state.aspect * by_parameters.col(1);
      by.col(0) = state.f * by_parameters.col(0) + by.col(1);
      by.middleCols<6>(2) = by_parameters.middleCols<6>(2);
      by.middleCols<3>(kNumLens) = -by_point * cross_matrix(turned);
      by.middleCols<3>(kNumLens + 3) = by_point;
      const Vector2d off = corner.pixel - *pixel;
      const double variance = corner.sd_px * corner.sd_px;
      const double weight = 1 / (variance * width * width +
                                 off.squaredNorm() / (kPanelTailSpreads * kPanelTailSpreads));
      // As small a product costs more by blocks.
      system += (weight * by.transpose()).lazyProduct(by);
      right += weight * by.transpose() * off;
    }
  }

  std::span<const PanelCorner> corners_;
  double side_;
  Vector2d centre_, middle_ = Vector2d::Zero();
  double unit_ = 1;
};

}  // namespace

Camera equidistant(double focal_sides, const ImageSize& size) {
  const double f = focal_sides * std::max(size.width, size.height);
  const Vector2d centre = image_centre(size);
  return {Fisheye({f, f, centre.x(), centre.y(), 0, 0, 0, 0}), size};
}

std::optional<Vector2d> PanelLens::pixel(const Vector2d& on_panel) const {
  return project(camera.lens, camera_from_panel * Vector3d(on_panel.x(), on_panel.y(), 0));
}

std::optional<PanelLens> lens_of_panel(std::span<const PanelCorner> corners, const ImageSize& size,
                                       const PanelLens* start) {
  if (corners.size() < kPanelMinCorners) return std::nullopt;
  const PanelFit fit(corners, size);
  std::vector<std::pair<double, State>> starts;
  if (start) {
    starts.emplace_back(0, fit.start(*start));
  } else {
    for (const double focal : kPanelFocals) {
      const auto state = fit.start(focal);
      const std::vector<double> off = state ? fit.distances(*state) : std::vector<double>();
      if (!off.empty()) starts.emplace_back(PanelFit::spread(off), *state);
    }
    std::ranges::sort(starts, {}, &std::pair<double, State>::first);
  }
  std::optional<State> best;
  double best_spread = 0;
  for (std::size_t i = 0; i < std::min(kStarts, starts.size()); ++i) {
    const auto end = fit.converge(starts[i].second);
    if (!end) continue;
    const double spread = PanelFit::spread(fit.distances(*end));
    if (best && spread >= best_spread) continue;
    best = end;
    best_spread = spread;
    if (spread < kExplained) break;
  }
  if (!best) return std::nullopt;
  // Converts the pose to the panel's own unit and origin.
  const Vector3d middle(fit.middle().x(), fit.middle().y(), 0);
  const Vector3d shift = fit.unit() * best->pose.translation() - best->pose.rotation() * middle;
  return PanelLens{
      {best->lens(), size}, Pose(best->pose.rotation(), shift), best_spread, fit.nearby(*best)};
}

}  // namespace tagcal::internal
