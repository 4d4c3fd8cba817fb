#include "tagcal/estimate/calibration/calibration_fit.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/held_parameters.hpp"
#include "tagcal/estimate/findings/finding_codes.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"

namespace tagcal::internal {
namespace {

using Clock = std::chrono::steady_clock;
using Eigen::Vector2d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMaxRounds = 15;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// The inliers, and the pose of each view (none: the view is not used).
struct Selection {
  std::vector<std::optional<Pose>> pose;
  std::vector<std::vector<std::uint8_t>> inlier;

  std::ptrdiff_t num_inliers(std::size_t view) const {
    return std::count(inlier[view].begin(), inlier[view].end(), 1);
  }
  bool uses(std::size_t view) const {
    return pose[view] &&
           num_inliers(view) >= static_cast<std::ptrdiff_t>(policy::kLeastViewCorners);
  }
};

// The bundle of the inliers; `views` are the indices of its views in the input.
Bundle selected_bundle(const Bundle& base, const CalibrationInput& input,
                       const Selection& selection, std::vector<std::size_t>& views) {
  Bundle bundle = base.without_views();
  ViewProblem bent;
  views.clear();
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    if (!selection.uses(v)) continue;
    bundle.views.push_back(chosen(base.bent(input.views[v].problem, bent), selection.inlier[v]));
    bundle.camera_from_target.push_back(*selection.pose[v]);
    views.push_back(v);
  }
  return bundle;
}

// Squared whitened residuals of all corners, per view.
std::vector<std::vector<double>> all_squares(const Bundle& bundle, const CalibrationInput& input,
                                             const Selection& selection) {
  const Lens lens = bundle.lens();
  ViewProblem bent;
  std::vector<std::vector<double>> squares(input.views.size());
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    const ViewProblem& view = bundle.bent(input.views[v].problem, bent);
    if (selection.pose[v])
      squares[v] = whitened_squares(view, lens, *selection.pose[v]);
    else
      squares[v].assign(view.correspondences.size(), kInfinity);
  }
  return squares;
}

// Robust standard deviation of the inliers' coordinates.
double robust_sigma(const std::vector<std::vector<double>>& squares, const Selection& selection) {
  std::vector<double> of_inliers;
  for (std::size_t v = 0; v < squares.size(); ++v)
    for (std::size_t i = 0; i < squares[v].size(); ++i)
      if (selection.inlier[v][i] && std::isfinite(squares[v][i]))
        of_inliers.push_back(squares[v][i]);
  return of_inliers.empty() ? kInfinity : std::sqrt(robust_variance(of_inliers));
}

// Takes the corners within `bound` as inliers. Returns true if any corner changes.
bool update_inliers(const std::vector<std::vector<double>>& squares, double bound,
                    Selection& selection) {
  bool changed = false;
  for (std::size_t v = 0; v < squares.size(); ++v) {
    for (std::size_t i = 0; i < squares[v].size(); ++i) {
      const std::uint8_t inlier = squares[v][i] <= bound * bound;
      changed |= inlier != selection.inlier[v][i];
      selection.inlier[v][i] = inlier;
    }
  }
  return changed;
}

// Estimates a new pose for views with few inliers: their start may come from a lens far from the
// one that is known now. Keeps a pose with more inliers; returns true if any view gets one.
bool reseed_views(const CalibrationInput& input, const Bundle& bundle, double bound,
                  Selection& selection) {
  const Lens lens = bundle.lens();
  bool any = false;
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    const std::ptrdiff_t count = selection.num_inliers(v);
    if (policy::is_above(count, policy::kReseedInliers, std::ssize(selection.inlier[v]))) continue;
    CalibrationView view = input.views[v];
    if (bundle.bent_board) bundle.bent_board->bend(view.problem, bundle.bend_m);
    const std::optional<Pose> pose = consensus_pose(view, lens);
    if (!pose) continue;
    int within = 0;
    for (const Vector2d& r : residuals_px(view.problem.correspondences, lens, *pose))
      within += r.norm() <= bound;
    if (within <= count) continue;
    selection.pose[v] = pose;
    any = true;
  }
  return any;
}

void reject_outside_domain(const Bundle& bundle, const CalibrationInput& input,
                           Selection& selection) {
  const auto squares = all_squares(bundle, input, selection);
  for (std::size_t v = 0; v < squares.size(); ++v)
    for (std::size_t i = 0; i < squares[v].size(); ++i)
      if (!std::isfinite(squares[v][i])) selection.inlier[v][i] = 0;
}

void list_outliers(const CalibrationInput& input, const Selection& selection,
                   const std::vector<std::vector<double>>& squares, CalibrationFit& fit) {
  ViewProblem bent;
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    const CalibrationView& view = input.views[v];
    fit.num_corners += static_cast<int>(view.ids.size());
    fit.squares.insert(fit.squares.end(), squares[v].begin(), squares[v].end());
    const bool is_used = selection.uses(v);
    if (!is_used)
      add(fit.findings, code::view_rejected,
          view.name() + ": rejected, its corners are not consistent with one pose");
    std::vector<Vector2d> residuals;
    if (selection.pose[v])
      residuals = residuals_px(fit.bundle.bent(view.problem, bent).correspondences,
                               fit.bundle.lens(), *selection.pose[v]);
    for (std::size_t i = 0; i < view.ids.size(); ++i)
      if (!is_used || !selection.inlier[v][i])
        fit.outliers.push_back(
            {view.image, view.ids[i],
             residuals.empty() ? std::numeric_limits<double>::quiet_NaN() : residuals[i].norm(),
             view.index, view.corners[i]});
  }
}

// A bundle solved on its inliers.
struct RobustState {
  Bundle bundle;
  Selection selection;
  BundleSummary summary;
  std::vector<std::size_t> used;             // indices of the bundle's views in the input
  std::vector<std::vector<double>> squares;  // of all corners
  double sigma = 0;                          // robust
};

// Solves and updates the inliers in turn until they are stable.
void update_until_stable(const CalibrationInput& input, const CalibrateOptions& options,
                         CalibrationFit& fit, RobustState& state) {
  for (int round = 0; round < kMaxRounds; ++round) {
    reject_outside_domain(state.bundle, input, state.selection);
    state.bundle = selected_bundle(state.bundle, input, state.selection, state.used);
    if (state.bundle.views.empty()) return;
    state.summary = solve(state.bundle, options.max_iterations, options.num_threads);
    fit.num_iterations += state.summary.num_iterations;
    for (std::size_t i = 0; i < state.used.size(); ++i)
      state.selection.pose[state.used[i]] = state.bundle.camera_from_target[i];
    state.squares = all_squares(state.bundle, input, state.selection);
    if (!options.reject_outliers) return;
    state.sigma = std::max(least_sigma(input.whitened, options),
                           robust_sigma(state.squares, state.selection));
    if (!update_inliers(state.squares, policy::kOutlierSigmas * state.sigma, state.selection))
      return;
  }
}

// Sum over all corners of min(square, bound^2).
double truncated_loss(const std::vector<std::vector<double>>& squares, double bound) {
  double sum = 0;
  for (const auto& of_view : squares)
    for (const double square : of_view) sum += std::min(square, bound * bound);
  return sum;
}

// Fits again with rejected corners taken back: right corners are outliers if the lens was fitted
// without them and is free there. A retry is kept if its truncated loss is lower and its sigma does
// not grow: a lens between two contradictory groups of corners has larger residuals.
void retry_borderline(const CalibrationInput& input, const CalibrateOptions& options,
                      CalibrationFit& fit, RobustState& state) {
  for (const double times : {2.0, 8.0, kInfinity}) {
    const double bound = policy::kOutlierSigmas * state.sigma;
    Selection wider = state.selection;
    if (!update_inliers(state.squares, times * bound, wider)) continue;
    RobustState other = state;
    other.selection = std::move(wider);
    update_until_stable(input, options, fit, other);
    if (other.bundle.views.empty() || (state.summary.converged && !other.summary.converged))
      continue;
    if (other.sigma < policy::kRetrySigmaGrowth * state.sigma &&
        truncated_loss(other.squares, bound) < truncated_loss(state.squares, bound))
      state = std::move(other);
  }
}

void fit_robustly(const CalibrationInput& input, const CalibrateOptions& options,
                  CalibrationFit& fit, Selection selection) {
  RobustState state{std::move(fit.bundle), std::move(selection), {}, {}, {}, 0};
  update_until_stable(input, options, fit, state);
  if (options.reject_outliers && !state.bundle.views.empty()) {
    const double wide = policy::kReseedSigmas * state.sigma;
    if (reseed_views(input, state.bundle, wide, state.selection)) {
      update_inliers(all_squares(state.bundle, input, state.selection), wide, state.selection);
      update_until_stable(input, options, fit, state);
    }
    retry_borderline(input, options, fit, state);
  }
  fit.bundle = std::move(state.bundle);
  fit.summary = state.summary;
  if (fit.bundle.views.empty()) state.squares = all_squares(fit.bundle, input, state.selection);
  for (const std::size_t v : state.used) {
    fit.views.push_back(input.views[v].index);
    fit.images.push_back(input.views[v].image);
  }
  list_outliers(input, state.selection, state.squares, fit);
}

}  // namespace

int CalibrationFit::num_inliers() const { return internal::num_corners(bundle); }

double CalibrationFit::truncated_chi_square(double sigma) const {
  double sum = 0;
  for (const double square : squares)
    sum += std::min(square / (sigma * sigma), policy::kOutlierSigmas * policy::kOutlierSigmas);
  return sum;
}

std::optional<CalibrationFit> fit_model(const Model& model, const CalibrationInput& input,
                                        const CalibrateOptions& options) {
  const auto begin = Clock::now();
  const auto start = calibration_seed(model, input.image_size, input.views, seed_options(options));
  if (!start) return std::nullopt;
  CalibrationFit fit;
  fit.bundle = Bundle{&model, input.image_size, start->free_values, {}, {}, input.bent_board};
  fit.whitened = input.whitened;
  fit.findings = input.findings;
  fit.start_seconds = seconds_since(begin);
  Selection selection{start->camera_from_world, start->inlier};
  if (!options.reject_outliers)
    for (auto& view : selection.inlier) std::fill(view.begin(), view.end(), 1);
  fit_robustly(input, options, fit, selection);
  if (fit.bundle.views.empty()) return std::nullopt;
  fit.solve_seconds = seconds_since(begin) - fit.start_seconds;
  return fit;
}

std::optional<CalibrationFit> refit(const Bundle& solved, const CalibrationFit& other,
                                    const CalibrationInput& input,
                                    const CalibrateOptions& options) {
  std::map<std::size_t, Pose> poses;
  for (std::size_t i = 0; i < other.views.size(); ++i)
    poses[other.views[i]] = solved.camera_from_target[i];
  std::set<std::pair<std::size_t, std::size_t>> rejected;
  for (const Outlier& o : other.outliers) rejected.emplace(o.view, o.corner);
  Selection selection;
  for (const CalibrationView& view : input.views) {
    const auto pose = poses.find(view.index);
    selection.pose.push_back(pose == poses.end() ? std::nullopt : std::optional(pose->second));
    auto& inlier = selection.inlier.emplace_back();
    for (const std::size_t i : view.corners) inlier.push_back(!rejected.contains({view.index, i}));
  }
  CalibrationFit fit{solved.without_views(), {}, {}, input.whitened};
  fit.findings = input.findings;
  fit_robustly(input, options, fit, selection);
  if (fit.bundle.views.empty()) return std::nullopt;
  return fit;
}

}  // namespace tagcal::internal
