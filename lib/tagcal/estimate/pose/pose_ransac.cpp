#include "tagcal/estimate/pose/pose_ransac.hpp"

#include <numbers>

#include "tagcal/estimate/pose/initial_poses.hpp"
#include "tagcal/estimate/pose/refine_pose.hpp"
#include "tagcal/solvers/numeric/inline_buffer.hpp"
#include "tagcal/solvers/numeric/point_spread.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"
#include "tagcal/solvers/p3p.hpp"
#include "tagcal/solvers/p4pf.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The poses of a view, for `ransac`.
template <int N>
class PoseFitter {
 public:
  using Model = ViewState;

  explicit PoseFitter(const RansacProblem& problem)
      : problem_(problem),
        view_(problem.view),
        shape_(spread_of(view_.points).shape),
        centre_(N == 7 ? principal_point(problem.lens) : Vector2d::Zero()),
        rays_(view_.size()),
        residuals_(problem.lens, view_) {
    for (std::size_t i = 0; i < view_.size(); ++i)
      if (find_rays(problem.lens, view_.pixels.subspan(i, 1), {&rays_[i], 1})) usable_.push_back(i);
  }

  // Correspondences whose pixel has a ray.
  std::span<const std::size_t> usable() const { return usable_; }
  std::size_t sample_size() const { return N == 6 ? 3 : 4; }

  // A pose that more than half of the known points agree with has no support by them: it may be the
  // known one.
  std::span<const double> squares(const ViewState& state) {
    const std::span<const double> all = residuals_.at(state);
    const auto agree = std::ranges::count_if(
        problem_.known, [&](std::size_t i) { return all[i] <= tolerance_square(); });
    if (2 * static_cast<std::size_t>(agree) <= problem_.known.size()) return all;
    squares_.assign(all.begin(), all.end());
    for (const std::size_t i : problem_.known)
      squares_[i] = std::numeric_limits<double>::infinity();
    return squares_;
  }
  double tolerance_square() const {
    return policy::kInlierSigmas * policy::kInlierSigmas * problem_.sigma_px * problem_.sigma_px;
  }

  void solve(std::span<const std::size_t> chosen, std::vector<ViewState>& states) const {
    InlineBuffer<Vector3d, 16> points(chosen.size()), rays(chosen.size());
    InlineBuffer<Vector2d, 16> pixels(chosen.size());
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      points[k] = view_.points[chosen[k]];
      pixels[k] = view_.pixels[chosen[k]] - centre_;
      rays[k] = rays_[chosen[k]];
    }
    if (chosen.size() > sample_size() || (N == 7 && shape_ == PointShape::plane)) {
      solve_plane(points.span(), rays.span(), pixels.span(), states);
    } else if constexpr (N == 6) {
      for (const Pose& pose :
           p3p(points.span().template first<3>(), rays.span().template first<3>()))
        states.push_back(state_of(pose));
    } else {
      for (const PoseAndFocal& s :
           p4pf(points.span().template first<4>(), pixels.span().template first<4>()))
        states.push_back(state_of(s.camera_from_target, s.focal_px));
    }
  }

  std::optional<ViewState> refit(const ViewState& start,
                                 std::span<const std::size_t> chosen) const {
    if (2 * chosen.size() < N) return std::nullopt;
    std::vector<Vector3d> points;
    std::vector<Vector2d> pixels;
    std::vector<Matrix2> whitening;
    for (const std::size_t i : chosen) {
      points.push_back(view_.points[i]);
      pixels.push_back(view_.pixels[i]);
      if (!view_.whitening.empty()) whitening.push_back(view_.whitening[i]);
    }
    ViewSums sums(problem_.lens, {points, pixels, whitening});
    const auto solution = refine_pose<N>(sums, {start}, {10});
    if (!solution) return std::nullopt;
    return solution->state;
  }

 private:
  // Adds the states of four points or more, if they lie in a plane.
  static void solve_plane(std::span<const Vector3d> points, std::span<const Vector3d> rays,
                          std::span<const Vector2d> pixels, std::vector<ViewState>& states) {
    const PointSpread spread = spread_of(points);
    if (spread.shape != PointShape::plane) return;
    InlineBuffer<Vector2d, 16> in_plane(points.size());
    for (std::size_t k = 0; k < points.size(); ++k)
      in_plane[k] = spread.in_plane(points[k]).template head<2>();
    const Pose plane_from_target = spread.plane_from_target_pose();
    if constexpr (N == 7) {
      if (const auto s = plane_pose_and_focal(in_plane.span(), pixels))
        states.push_back(state_of(s->camera_from_target * plane_from_target, s->focal_px));
    } else if (const auto h = homography(in_plane.span(), rays)) {
      for (const Pose& pose : ippe(*h)) states.push_back(state_of(pose * plane_from_target));
    }
  }

  const RansacProblem& problem_;
  ViewPoints view_;
  PointShape shape_;
  Vector2d centre_;  // the principal point
  std::vector<Vector3d> rays_;
  std::vector<std::size_t> usable_;
  ViewResiduals residuals_;
  std::vector<double> squares_;
};

// Width of the image region by the range between the quartiles, which a few distant pixels do not
// change.
double spread_px(std::span<const Vector2d> pixels, Eigen::Index axis) {
  std::vector<double> sorted;
  for (const Vector2d& p : pixels) sorted.push_back(p[axis]);
  std::sort(sorted.begin(), sorted.end());
  const std::size_t quarter = (sorted.size() + 1) / 4;
  return 2 * (sorted[sorted.size() - 1 - quarter] - sorted[quarter]);
}

// Tests the number of false alarms (Moisan & Stival, IJCV 2004) of k of n points within the
// tolerance. `squares` are the squared residuals of the consensus.
bool may_be_chance(const ViewPoints& view, const PoseConsensus& consensus,
                   std::span<const double> squares, double tolerance_square,
                   std::size_t sample_size) {
  const double image = spread_px(view.pixels, 0) * spread_px(view.pixels, 1);
  double area = std::numbers::pi * tolerance_square;  // of the tolerance
  if (!view.whitening.empty()) {
    double mean = 0;
    for (const Matrix2& w : view.whitening) mean += 1 / std::abs(w.determinant());
    area *= mean / static_cast<double>(view.size());
  }
  const double n = static_cast<double>(view.size());
  const double k = static_cast<double>(consensus.inliers.size());
  // Wrong corners that are nearly right (a mirrored target, a wrong lens) are denser than evenly
  // spread ones, so the density of the corners around the tolerance counts as well. Their number
  // grows with the tolerance, not with its square: of points that are mirrored through a plane,
  // those near the plane agree.
  constexpr double kAround = policy::kDensityTolerances;
  const auto is_around = [&](double square) {
    return square <= kAround * kAround * tolerance_square;
  };
  const double around = static_cast<double>(std::ranges::count_if(squares, is_around)) - k;
  const double nearby = around + 0.5;  // numeric: counts half a corner more, for a density above 0
  const double share = std::min(1.0, std::max(area / image, nearby / (n * (kAround - 1))));
  const double s = static_cast<double>(sample_size);
  if (k <= s) return true;
  const double log_choices = log_gamma(n - s + 1) - log_gamma(k - s + 1) - log_gamma(n - k + 1);
  return std::log(4.0 * consensus.num_samples) + log_choices + (k - s) * std::log(share) >
         std::log(policy::kWrongConsensus);
}

}  // namespace

template <int N>
std::optional<PoseConsensus> pose_ransac(const RansacProblem& problem) {
  if (problem.view.points.empty()) return std::nullopt;
  PoseFitter<N> fitter(problem);
  const TruncatedSquares score{fitter.tolerance_square()};
  RansacOptions options{problem.seed, problem.groups};
  options.groups_per_sample = N == 6 ? 1 : 2;  // two tags determine the focal length better
  options.least_share = problem.least_share;
  std::optional<PoseConsensus> consensus = ransac(fitter, score, options);
  if (consensus && may_be_chance(problem.view, *consensus, fitter.squares(consensus->model),
                                 fitter.tolerance_square(), fitter.sample_size()))
    return std::nullopt;
  return consensus;
}

template std::optional<PoseConsensus> pose_ransac<6>(const RansacProblem&);
template std::optional<PoseConsensus> pose_ransac<7>(const RansacProblem&);

}  // namespace tagcal::internal
