#include "tagcal/estimate/pose/pose_ransac.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/pose/initial_poses.hpp"
#include "tagcal/estimate/pose/pose_minima.hpp"
#include "tagcal/estimate/pose/refine_pose.hpp"
#include "tagcal/random.hpp"
#include "tagcal/solvers/numeric/point_spread.hpp"
#include "tagcal/solvers/p3p.hpp"
#include "tagcal/solvers/p4pf.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMissed = 1e-4;    // probability that a better consensus was missed
constexpr double kByChance = 1e-5;  // probability that the consensus means nothing
constexpr int kMaxSamples = 50000;
constexpr double kToleranceSigmas = 4;  // an inlier's residual length is longer once in 3,000

using States = Solutions<ViewState, 8>;

// States that agree with a few correspondences.
template <int N>
class SampleSolver {
 public:
  explicit SampleSolver(const RobustView& robust)
      : view_(robust.view), spread_(spread_of(robust.view.points)) {
    rays_.resize(view_.size());
    usable_.reserve(view_.size());
    const auto p = parameters(robust.lens);
    centre_ = N == 7 ? Vector2d(p[kCx], p[kCy]) : Vector2d::Zero();
    for (std::size_t i = 0; i < view_.size(); ++i)
      if (find_rays(robust.lens, view_.pixels.subspan(i, 1), {&rays_[i], 1})) usable_.push_back(i);
  }

  // Correspondences whose pixel has a ray.
  const std::vector<std::size_t>& usable() const { return usable_; }

  // Of single points: three, with focal length four.
  void solve_points(std::span<const std::size_t> chosen, States& states) const {
    if constexpr (N == 6) {
      const std::array points = {point(chosen[0]), point(chosen[1]), point(chosen[2])};
      const std::array rays = {rays_[chosen[0]], rays_[chosen[1]], rays_[chosen[2]]};
      for (const Pose& pose : p3p(points, rays)) states.push_back(state_of(pose));
    } else if (spread_.shape == PointShape::plane) {
      solve_plane(chosen, states);
    } else {
      std::array<Vector3d, 4> points;
      std::array<Vector2d, 4> pixels;
      for (std::size_t k = 0; k < 4; ++k) {
        points[k] = point(chosen[k]);
        pixels[k] = view_.pixels[chosen[k]] - centre_;
      }
      for (const PoseAndFocal& solution : p4pf(points, pixels))
        states.push_back(state_of(solution.camera_from_target, solution.focal_px));
    }
  }

  // Of four points or more in a plane.
  void solve_plane(std::span<const std::size_t> chosen, States& states) const {
    InlineBuffer<Vector3d, 16> points(chosen.size()), rays(chosen.size());
    for (std::size_t k = 0; k < chosen.size(); ++k) points[k] = point(chosen[k]);
    const PointSpread spread = spread_of(points.span());
    if (spread.shape != PointShape::plane) return;
    InlineBuffer<Vector2d, 16> in_plane(chosen.size()), pixels(chosen.size());
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      in_plane[k] = spread.in_plane(points[k]).head<2>();
      rays[k] = rays_[chosen[k]];
      pixels[k] = view_.pixels[chosen[k]] - centre_;
    }
    const Pose plane_from_target = spread.plane_from_target_pose();
    if constexpr (N == 7) {
      if (const auto s = plane_pose_and_focal(in_plane.span(), pixels.span()))
        states.push_back(state_of(s->camera_from_target * plane_from_target, s->focal_px));
    } else if (const auto h = homography(in_plane.span(), rays.span())) {
      for (const Pose& pose : ippe(*h)) states.push_back(state_of(pose * plane_from_target));
    }
  }

 private:
  const Vector3d& point(std::size_t i) const { return view_.points[i]; }

  ViewPoints view_;
  PointSpread spread_;
  Vector2d centre_;  // the principal point
  std::vector<Vector3d> rays_;
  std::vector<std::size_t> usable_;
};

// What a state scores: the sum of min(r^2, tolerance^2), and who is within the tolerance.
class Scorer {
 public:
  explicit Scorer(const RobustView& robust)
      : robust_(robust), residuals_(robust.lens, robust.view) {
    const double tolerance = kToleranceSigmas * robust.sigma_px;
    tolerance_square_ = tolerance * tolerance;
  }

  double loss(const ViewState& state) {
    double sum = 0;
    for (const double square : residuals_.at(state)) sum += std::min(square, tolerance_square_);
    return sum;
  }

  std::vector<std::size_t> within(const ViewState& state, double tolerances) {
    std::vector<std::size_t> result;
    const std::span<const double> squares = residuals_.at(state);
    for (std::size_t i = 0; i < squares.size(); ++i)
      if (squares[i] <= tolerances * tolerances * tolerance_square_) result.push_back(i);
    return result;
  }

  double tolerance_square() const { return tolerance_square_; }

 private:
  const RobustView& robust_;
  ViewResiduals residuals_;
  double tolerance_square_;
};

// The least-squares state of some of the correspondences.
template <int N>
std::optional<ViewState> refined(const RobustView& robust, const ViewState& start,
                                 std::span<const std::size_t> chosen) {
  std::vector<Vector3d> points;
  std::vector<Vector2d> pixels;
  std::vector<Matrix2> whitening;
  for (const std::size_t i : chosen) {
    points.push_back(robust.view.points[i]);
    pixels.push_back(robust.view.pixels[i]);
    if (!robust.view.whitening.empty()) whitening.push_back(robust.view.whitening[i]);
  }
  if (2 * points.size() < N) return std::nullopt;
  ViewSums sums(robust.lens, {points, pixels, whitening});
  const auto solution = solve_view<N>(sums, {start}, {10});
  if (!solution) return std::nullopt;
  return solution->state;
}

template <int N>
class Search {
 public:
  explicit Search(const RobustView& robust)
      : robust_(robust), solver_(robust), scorer_(robust), random_(robust.seed) {
    std::map<int, std::vector<std::size_t>> groups;
    if (!robust.groups.empty())
      for (const std::size_t i : solver_.usable()) groups[robust.groups[i]].push_back(i);
    for (const auto& [id, members] : groups)
      if (members.size() >= 4) groups_.push_back(members);
  }

  std::optional<ViewConsensus> run() {
    constexpr std::size_t kSampleSize = N == 6 ? 3 : 4;
    if (solver_.usable().size() < kSampleSize + 1) return std::nullopt;
    int wanted = samples_for(robust_.least_share, kSampleSize), taken = 0;
    for (; taken < wanted; ++taken) {
      States states;
      if (taken % 2 == 0 && !groups_.empty())
        sample_groups(static_cast<std::size_t>(taken / 2), states);
      else
        sample_points(states);
      if (consider(states)) wanted = samples_needed(kSampleSize);
    }
    if (!best_) return std::nullopt;
    ViewConsensus consensus{*best_, scorer_.within(*best_, 1), taken};
    if (by_chance(consensus, kSampleSize)) return std::nullopt;
    return consensus;
  }

 private:
  // One tag after the other; with the focal length two of them, which together show more of it.
  void sample_groups(std::size_t round, States& states) {
    std::vector<std::size_t> chosen = groups_[round % groups_.size()];
    if (N == 7 && groups_.size() > 1) {
      const auto& other = groups_[random_.index(groups_.size())];
      if (other != chosen) chosen.insert(chosen.end(), other.begin(), other.end());
    }
    solver_.solve_plane(chosen, states);
  }

  void sample_points(States& states) {
    const std::vector<std::size_t>& usable = solver_.usable();
    std::array<std::size_t, N == 6 ? 3 : 4> chosen;
    for (std::size_t k = 0; k < chosen.size();) {
      chosen[k] = usable[random_.index(usable.size())];
      if (std::find(chosen.begin(), chosen.begin() + k, chosen[k]) == chosen.begin() + k) ++k;
    }
    solver_.solve_points(chosen, states);
  }

  // Whether one of them, refined on those that agree with it, is better than the best.
  bool consider(const States& states) {
    bool improved = false;
    for (const ViewState& state : states) {
      const double loss = scorer_.loss(state);
      if (!(loss < sample_loss_)) continue;
      sample_loss_ = loss;
      improved |= keep(state, loss);
      ViewState local = state;
      for (const double tolerances : {3.0, 2.0, 1.5, 1.0}) {
        const auto better = refined<N>(robust_, local, scorer_.within(local, tolerances));
        if (!better) break;
        local = *better;
        improved |= keep(local, scorer_.loss(local));
      }
    }
    return improved;
  }

  bool keep(const ViewState& state, double loss) {
    if (!(loss < best_loss_)) return false;
    best_ = state;
    best_loss_ = loss;
    return true;
  }

  int samples_needed(std::size_t sample_size) {
    const double n = static_cast<double>(solver_.usable().size());
    const double share = static_cast<double>(scorer_.within(*best_, 1).size()) / n;
    return samples_for(std::max(share, robust_.least_share), sample_size);
  }

  // Until a consensus of that share has been missed no more than so rarely.
  static int samples_for(double share, std::size_t sample_size) {
    if (share <= 0) return kMaxSamples;
    const double good = std::pow(share, static_cast<double>(sample_size));
    if (good >= 1) return 1;
    // Twice as many: every other sample is of a group.
    const double count = 2 * std::log(kMissed) / std::log1p(-good);
    return static_cast<int>(std::min<double>(kMaxSamples, std::ceil(count)));
  }

  // The width that pixels spread over evenly would have: a few far ones do not stretch it.
  double spread_px(Eigen::Index axis) const {
    std::vector<double> sorted;
    for (const Vector2d& p : robust_.view.pixels) sorted.push_back(p[axis]);
    std::sort(sorted.begin(), sorted.end());
    const std::size_t quarter = (sorted.size() + 1) / 4;
    return 2 * (sorted[sorted.size() - 1 - quarter] - sorted[quarter]);
  }

  // The number of false alarms (Moisan & Stival, IJCV 2004) of k of n within the tolerance.
  bool by_chance(const ViewConsensus& consensus, std::size_t sample_size) {
    const double image = spread_px(0) * spread_px(1);
    double area = std::numbers::pi * scorer_.tolerance_square();  // of a corner's tolerance
    if (!robust_.view.whitening.empty()) {
      double mean = 0;
      for (const Matrix2& w : robust_.view.whitening) mean += 1 / std::abs(w.determinant());
      area *= mean / static_cast<double>(robust_.view.size());
    }
    const double n = static_cast<double>(robust_.view.size());
    const double k = static_cast<double>(consensus.inliers.size());
    // Wrong corners that are nearly right (a target seen mirrored, a wrong lens) lie closer than
    // that: as those around the tolerance do. Of points that are mirrored through a plane those
    // near to it agree, and their number grows as the tolerance, not as its square. (Where there
    // are none, half a one.)
    constexpr double kAround = 10;  // tolerances
    const double around = static_cast<double>(scorer_.within(consensus.state, kAround).size()) - k;
    const double share =
        std::min(1.0, std::max(area / image, (around + 0.5) / (n * (kAround - 1))));
    const double s = static_cast<double>(sample_size);
    if (k <= s) return true;
    const double log_choices =
        std::lgamma(n - s + 1) - std::lgamma(k - s + 1) - std::lgamma(n - k + 1);
    return std::log(4.0 * consensus.num_samples) + log_choices + (k - s) * std::log(share) >
           std::log(kByChance);
  }

  const RobustView& robust_;
  SampleSolver<N> solver_;
  Scorer scorer_;
  Random random_;
  std::vector<std::vector<std::size_t>> groups_;
  std::optional<ViewState> best_;
  double best_loss_ = std::numeric_limits<double>::infinity();
  double sample_loss_ = std::numeric_limits<double>::infinity();
};

}  // namespace

template <int N>
std::optional<ViewConsensus> find_view_consensus(const RobustView& view) {
  if (view.view.points.empty()) return std::nullopt;
  return Search<N>(view).run();
}

template std::optional<ViewConsensus> find_view_consensus<6>(const RobustView&);
template std::optional<ViewConsensus> find_view_consensus<7>(const RobustView&);

}  // namespace tagcal::internal
