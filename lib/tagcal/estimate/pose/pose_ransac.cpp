#include "tagcal/estimate/pose/pose_ransac.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/initial_poses.hpp"
#include "tagcal/estimate/pose/pose_minima.hpp"
#include "tagcal/estimate/pose/refine_pose.hpp"
#include "tagcal/random.hpp"
#include "tagcal/solvers/numeric/point_spread.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"
#include "tagcal/solvers/p3p.hpp"
#include "tagcal/solvers/p4pf.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMaxSamples = 50000;

using States = Solutions<ViewState, 8>;

// Minimal solvers: states that fit a few correspondences.
template <int N>
class SampleSolver {
 public:
  explicit SampleSolver(const RansacProblem& problem)
      : view_(problem.view), spread_(spread_of(problem.view.points)) {
    rays_.resize(view_.size());
    usable_.reserve(view_.size());
    const auto p = parameters(problem.lens);
    centre_ = N == 7 ? Vector2d(p[kCx], p[kCy]) : Vector2d::Zero();
    for (std::size_t i = 0; i < view_.size(); ++i)
      if (find_rays(problem.lens, view_.pixels.subspan(i, 1), {&rays_[i], 1})) usable_.push_back(i);
  }

  // Correspondences whose pixel has a ray.
  const std::vector<std::size_t>& usable() const { return usable_; }

  // Adds the states of single points: three, with focal length four.
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

  // Adds the states of four points or more in a plane.
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

// Scores states: the sum of min(r^2, tolerance^2), and the points within the tolerance.
class Scorer {
 public:
  explicit Scorer(const RansacProblem& problem) : residuals_(problem.lens, problem.view) {
    const double tolerance = policy::kInlierSigmas * problem.sigma_px;
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
  ViewResiduals residuals_;
  double tolerance_square_;
};

// Returns the least-squares state of the chosen correspondences.
template <int N>
std::optional<ViewState> refined(const RansacProblem& problem, const ViewState& start,
                                 std::span<const std::size_t> chosen) {
  std::vector<Vector3d> points;
  std::vector<Vector2d> pixels;
  std::vector<Matrix2> whitening;
  for (const std::size_t i : chosen) {
    points.push_back(problem.view.points[i]);
    pixels.push_back(problem.view.pixels[i]);
    if (!problem.view.whitening.empty()) whitening.push_back(problem.view.whitening[i]);
  }
  if (2 * points.size() < N) return std::nullopt;
  ViewSums sums(problem.lens, {points, pixels, whitening});
  const auto solution = refine_pose<N>(sums, {start}, {10});
  if (!solution) return std::nullopt;
  return solution->state;
}

template <int N>
class Search {
 public:
  explicit Search(const RansacProblem& problem)
      : problem_(problem), solver_(problem), scorer_(problem), random_(problem.seed) {
    std::map<int, std::vector<std::size_t>> groups;
    if (!problem.groups.empty())
      for (const std::size_t i : solver_.usable()) groups[problem.groups[i]].push_back(i);
    for (const auto& [id, members] : groups)
      if (members.size() >= 4) groups_.push_back(members);
  }

  std::optional<PoseConsensus> run() {
    constexpr std::size_t kSampleSize = N == 6 ? 3 : 4;
    if (solver_.usable().size() < kSampleSize + 1) return std::nullopt;
    int wanted = samples_for(problem_.least_share, kSampleSize), taken = 0;
    for (; taken < wanted; ++taken) {
      States states;
      if (taken % 2 == 0 && !groups_.empty())
        sample_groups(static_cast<std::size_t>(taken / 2), states);
      else
        sample_points(states);
      if (consider(states)) wanted = samples_needed(kSampleSize);
    }
    if (!best_) return std::nullopt;
    PoseConsensus consensus{*best_, scorer_.within(*best_, 1), taken};
    if (may_be_chance(consensus, kSampleSize)) return std::nullopt;
    return consensus;
  }

 private:
  // Draws one tag after the other; with the focal length two, which determine it better.
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

  // Returns true if one of the states, or its local optimisation on its inliers, is better than the
  // best so far.
  bool consider(const States& states) {
    bool improved = false;
    for (const ViewState& state : states) {
      const double loss = scorer_.loss(state);
      if (!(loss < sample_loss_)) continue;
      sample_loss_ = loss;
      improved |= keep(state, loss);
      ViewState local = state;
      for (const double tolerances : {3.0, 2.0, 1.5, 1.0}) {  // numeric: tried values
        const auto better = refined<N>(problem_, local, scorer_.within(local, tolerances));
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
    return samples_for(std::max(share, problem_.least_share), sample_size);
  }

  // Number of samples that miss a consensus with this share of inliers with probability
  // kMissedConsensus.
  static int samples_for(double share, std::size_t sample_size) {
    if (share <= 0) return kMaxSamples;
    const double good = std::pow(share, static_cast<double>(sample_size));
    if (good >= 1) return 1;
    // Twice as many, because every other sample is a group.
    const double count = 2 * std::log(policy::kMissedConsensus) / std::log1p(-good);
    return static_cast<int>(std::min<double>(kMaxSamples, std::ceil(count)));
  }

  // Width of the image region by the range between the quartiles, which a few distant pixels do not
  // change.
  double spread_px(Eigen::Index axis) const {
    std::vector<double> sorted;
    for (const Vector2d& p : problem_.view.pixels) sorted.push_back(p[axis]);
    std::sort(sorted.begin(), sorted.end());
    const std::size_t quarter = (sorted.size() + 1) / 4;
    return 2 * (sorted[sorted.size() - 1 - quarter] - sorted[quarter]);
  }

  // Tests the number of false alarms (Moisan & Stival, IJCV 2004) of k of n points within the
  // tolerance.
  bool may_be_chance(const PoseConsensus& consensus, std::size_t sample_size) {
    const double image = spread_px(0) * spread_px(1);
    double area = std::numbers::pi * scorer_.tolerance_square();  // of the tolerance
    if (!problem_.view.whitening.empty()) {
      double mean = 0;
      for (const Matrix2& w : problem_.view.whitening) mean += 1 / std::abs(w.determinant());
      area *= mean / static_cast<double>(problem_.view.size());
    }
    const double n = static_cast<double>(problem_.view.size());
    const double k = static_cast<double>(consensus.inliers.size());
    // Wrong corners that are nearly right (a mirrored target, a wrong lens) are denser than evenly
    // spread ones, so the density of the corners around the tolerance counts as well. Their number
    // grows with the tolerance, not with its square: of points that are mirrored through a plane,
    // those near the plane agree.
    constexpr double kAround = policy::kDensityTolerances;
    const double around = static_cast<double>(scorer_.within(consensus.state, kAround).size()) - k;
    const double nearby = around + 0.5;  // numeric: half a corner where there is none
    const double share = std::min(1.0, std::max(area / image, nearby / (n * (kAround - 1))));
    const double s = static_cast<double>(sample_size);
    if (k <= s) return true;
    const double log_choices = log_gamma(n - s + 1) - log_gamma(k - s + 1) - log_gamma(n - k + 1);
    return std::log(4.0 * consensus.num_samples) + log_choices + (k - s) * std::log(share) >
           std::log(policy::kChanceConsensus);
  }

  const RansacProblem& problem_;
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
std::optional<PoseConsensus> pose_ransac(const RansacProblem& view) {
  if (view.view.points.empty()) return std::nullopt;
  return Search<N>(view).run();
}

template std::optional<PoseConsensus> pose_ransac<6>(const RansacProblem&);
template std::optional<PoseConsensus> pose_ransac<7>(const RansacProblem&);

}  // namespace tagcal::internal
