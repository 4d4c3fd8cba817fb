#include "tagcal/estimate/calibration/calibration_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/bundle/rolling_shutter.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/robust_pose.hpp"
#include "tagcal/internal/stopwatch.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMaxRounds = 15;
constexpr int kRowRounds = 3;

double robust_sigma(const RobustState& state) {
  std::vector<double> of_inliers;
  for (std::size_t v = 0; v < state.squares.size(); ++v)
    for (std::size_t i = 0; i < state.squares[v].size(); ++i)
      if (state.selection.inlier[v][i] && std::isfinite(state.squares[v][i]))
        of_inliers.push_back(state.squares[v][i]);
  return of_inliers.empty() ? kInfinity : std::sqrt(robust_variance(of_inliers));
}

// Takes the corners within `bound` as inliers. Returns true if any corner changes.
bool update_inliers(RobustState& state, double bound) {
  bool changed = false;
  for (std::size_t v = 0; v < state.squares.size(); ++v) {
    for (std::size_t i = 0; i < state.squares[v].size(); ++i) {
      const std::uint8_t inlier = state.squares[v][i] <= bound * bound;
      changed |= inlier != std::exchange(state.selection.inlier[v][i], inlier);
    }
  }
  return changed;
}

// Sum over all corners of min(square, bound^2).
double truncated_loss(const RobustState& state, double bound) {
  double sum = 0;
  for (const auto& of_view : state.squares)
    for (const double square : of_view) sum += std::min(square, bound * bound);
  return sum;
}

// A bundle solved on its inliers.
struct BundleState : RobustState {
  Bundle bundle;
  BundleSummary summary;
  std::vector<std::size_t> used;  // indices of the bundle's views in the input
  int num_iterations = 0;
};

void set_squares(BundleState& state, const CalibrationInput& input) {
  const Lens lens = state.bundle.lens();
  ViewProblem buffer;
  state.squares.resize(input.views.size());
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    const ViewProblem& view = input.views[v].problem;
    const std::optional<Pose>& pose = state.selection.pose[v];
    if (pose) {
      // Stays at its place in memory, and so leaves no holes beside what the solver takes and
      // frees.
      const std::vector<double> squares = whitened_squares(
          state.bundle.corrected(view, state.selection.row_terms[v], buffer), lens, *pose);
      state.squares[v].assign(squares.begin(), squares.end());
    } else {
      state.squares[v].assign(view.correspondences.size(), kInfinity);
    }
  }
}

// The bundle of the inliers within the domain of the lens.
void select_bundle(BundleState& state, const CalibrationInput& input) {
  if (state.squares.empty()) set_squares(state, input);
  Bundle bundle = state.bundle.without_views();
  state.used.clear();
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    auto& inlier = state.selection.inlier[v];
    for (std::size_t i = 0; i < inlier.size(); ++i)
      if (!std::isfinite(state.squares[v][i])) inlier[i] = 0;
    if (!state.selection.uses(v)) continue;
    bundle.views.push_back(chosen(input.views[v].problem, inlier));
    bundle.camera_from_target.push_back(*state.selection.pose[v]);
    bundle.row_terms.push_back(state.selection.row_terms[v]);
    state.used.push_back(v);
  }
  state.bundle = std::move(bundle);
}

using Solve = BundleSummary(Bundle& bundle, int max_iterations, std::size_t num_threads);

void update_until_stable(BundleState& state, const CalibrationInput& input,
                         const CalibrateOptions& options, Solve& solve) {
  update_until_stable(state, input.whitened, options, [&] {
    select_bundle(state, input);
    if (state.bundle.views.empty()) return false;
    if (state.noise > 0) state.bundle.sigma = state.noise;
    state.summary = solve(state.bundle, options.max_iterations, options.num_threads);
    state.num_iterations += state.summary.num_iterations;
    for (std::size_t i = 0; i < state.used.size(); ++i) {
      state.selection.pose[state.used[i]] = state.bundle.camera_from_target[i];
      state.selection.row_terms[state.used[i]] = state.bundle.row_terms[i];
    }
    set_squares(state, input);
    return true;
  });
}

// The inliers need no minimum to many digits, which a lens that fits badly takes long to reach.
void solve_robustly(BundleState& state, const CalibrationInput& input,
                    const CalibrateOptions& options) {
  update_until_stable(state, input, options, solve);
  if (!state.bundle.views.empty() && !state.summary.converged)
    update_until_stable(state, input, options, solve_until_converged);
}

double bound(const BundleState& state) { return policy::kOutlierSigmas * state.sigma; }

// Solves again from another selection; keeps the better fit: that of the lower truncated loss.
void retry(BundleState& state, BundleState trial, const CalibrationInput& input,
           const CalibrateOptions& options) {
  solve_robustly(trial, input, options);
  state.num_iterations = trial.num_iterations;
  if (!trial.bundle.views.empty() && trial.summary.converged >= state.summary.converged &&
      truncated_loss(trial, bound(state)) < truncated_loss(state, bound(state)))
    state = std::move(trial);
}

// Solves again with all corners: right ones are outliers if the lens was fitted without them and is
// free there.
void retry_with_all(BundleState& state, const CalibrationInput& input,
                    const CalibrateOptions& options) {
  BundleState trial = state;
  if (update_inliers(trial, kInfinity)) retry(state, std::move(trial), input, options);
}

// Solves again with other poses of the views that lost corners: a view may have started at a wrong
// minimum, under the lens that was known then.
void retry_with_other_poses(BundleState& state, const CalibrationInput& input,
                            const CalibrateOptions& options) {
  BundleState trial = state;
  const Lens lens = state.bundle.lens();
  bool any = false;
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    const ViewProblem& view = input.views[v].problem;
    const auto inliers = state.selection.num_inliers(v);
    if (!policy::is_below(inliers, policy::kComparableInliers,
                          std::ssize(state.selection.inlier[v])))
      continue;
    const RobustPose<6> pose = fit_pose_robustly<6>(view.correspondences, lens, {});
    if (!pose.fit) continue;
    trial.selection.pose[v] = pose.camera_from_target();
    trial.selection.row_terms[v].setZero();
    any = true;
  }
  if (!any) return;
  set_squares(trial, input);
  update_inliers(trial, bound(state));
  retry(state, std::move(trial), input, options);
}

// Solves again with the row terms that the views show: a shear, or velocities.
void add_row_terms(BundleState& state, const CalibrationInput& input,
                   const CalibrateOptions& options) {
  if (!input.has_rows.value_or(true)) return;
  Bundle& bundle = state.bundle;
  double row_sigma = row_sigma_of(bundle, bundle.sigma);
  if (!(row_sigma > 0)) return;
  const double of_velocities =
      rolling_sigma_of(bundle, options.max_iterations, options.num_threads);
  if (of_velocities > 0) bundle.rolling_m = median_distance_m(bundle);
  for (int round = 0; round < kRowRounds && !bundle.views.empty(); ++round) {
    if (!bundle.is_rolling() && row_sigma <= bundle.row_sigma) break;
    bundle.row_sigma = bundle.is_rolling() ? of_velocities : row_sigma;
    solve_robustly(state, input, options);
    // Lens and poses take up a part of what the rows show, so the next solution may show more.
    if (!bundle.is_rolling() && !bundle.views.empty())
      row_sigma = row_sigma_of(bundle, bundle.sigma);
  }
}

// The fit of a model from a start.
std::optional<CalibrationFit> fit_from(const Bundle& start, Selection selection,
                                       const CalibrationInput& input,
                                       const CalibrateOptions& options) {
  const double sigma = options.sigma_px > 0 || !input.whitened ? options.sigma_px : 1;
  BundleState state{{std::move(selection), {}, sigma, 0}, start, {}, {}, 0};
  solve_robustly(state, input, options);
  if (state.bundle.views.empty()) return std::nullopt;
  if (options.reject_outliers) {
    retry_with_all(state, input, options);
    retry_with_other_poses(state, input, options);
  }
  state.bundle.sigma = state.noise;
  add_row_terms(state, input, options);
  if (state.bundle.views.empty()) return std::nullopt;
  CalibrationFit fit;
  fit.bundle = std::move(state.bundle);
  fit.used = state.used;
  fit.whitened = input.whitened;
  fit.summary = state.summary;
  fit.num_iterations = state.num_iterations;
  take_selection(input, std::move(state), fit);
  return fit;
}

// Squares of the inliers by the fit's own bundle.
void set_inlier_squares(CalibrationFit& fit) {
  const Lens lens = fit.bundle.lens();
  ViewProblem buffer;
  for (std::size_t k = 0; k < fit.used.size(); ++k) {
    const std::vector<double> of_view =
        whitened_squares(fit.bundle.corrected(k, buffer), lens, fit.bundle.camera_from_target[k]);
    const auto& inlier = fit.selection.inlier[fit.used[k]];
    auto next = of_view.begin();
    for (std::size_t i = 0; i < inlier.size(); ++i)
      if (inlier[i]) fit.squares[fit.used[k]][i] = *next++;
  }
  fit.more_cost = 0;
}

}  // namespace

Lens CalibrationFit::lens(std::size_t view) const {
  if (has_perspective()) return bundle.lens();
  const Vector2d centre = image_centre(bundle.image_size);
  const double scale = selection.scale_px_per_m[view];
  return Parallel({scale, scale, centre.x(), centre.y()});
}

int CalibrationFit::num_inliers() const { return internal::num_corners(bundle); }

double CalibrationFit::truncated_chi_square(double sigma) const {
  double sum = more_cost / (sigma * sigma);
  for (const auto& of_view : squares)
    for (const double square : of_view)
      sum += std::min(square / (sigma * sigma), policy::kOutlierSigmas * policy::kOutlierSigmas);
  return sum;
}

std::ptrdiff_t Selection::num_inliers(std::size_t view) const {
  return std::count(inlier[view].begin(), inlier[view].end(), 1);
}

bool Selection::uses(std::size_t view) const {
  return pose[view] && num_inliers(view) >= std::ptrdiff_t{policy::kLeastViewCorners};
}

Selection selection_of(const CalibrationSeed& seed, const CalibrateOptions& options) {
  Selection selection{seed.camera_from_world,
                      seed.inlier,
                      std::vector<Vector6d>(seed.inlier.size(), Vector6d::Zero()),
                      {}};
  if (!options.reject_outliers)
    for (auto& view : selection.inlier) std::fill(view.begin(), view.end(), 1);
  return selection;
}

void update_until_stable(RobustState& state, bool whitened, const CalibrateOptions& options,
                         const std::function<bool()>& solve) {
  for (int round = 0; round < kMaxRounds; ++round) {
    const double before = state.noise;
    if (!solve()) return;
    state.noise = std::max(kLeastNoisePx, robust_sigma(state));
    state.sigma = std::max(least_sigma(whitened, options), state.noise);
    const bool is_changed =
        options.reject_outliers && update_inliers(state, policy::kOutlierSigmas * state.sigma);
    // The noise weighs the priors.
    if (!is_changed && std::abs(state.noise - before) <= policy::kNoiseChange * state.noise) return;
  }
}

void take_selection(const CalibrationInput& input, RobustState state, CalibrationFit& fit) {
  fit.selection = std::move(state.selection);
  fit.squares = std::move(state.squares);
  fit.findings = input.findings;
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    fit.num_corners += static_cast<int>(input.views[v].ids.size());
    if (!std::ranges::binary_search(fit.used, v))
      add(fit.findings, code::view_rejected,
          input.views[v].name() + ": rejected, its corners are not consistent with one pose");
  }
}

std::vector<Outlier> outliers_of(const CalibrationInput& input, const CalibrationFit& fit) {
  const Selection& selection = fit.selection;
  std::vector<Outlier> outliers;
  ViewProblem buffer;
  std::size_t next = 0;
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    const CalibrationView& view = input.views[v];
    const bool is_used = next < fit.used.size() && fit.used[next] == v;
    std::optional<Pose> pose = selection.pose[v];
    Vector6d rows = selection.row_terms[v];
    if (is_used) {
      pose = fit.bundle.camera_from_target[next];
      if (!fit.bundle.row_terms.empty()) rows = fit.bundle.row_terms[next];
      ++next;
    }
    if (is_used && selection.num_inliers(v) == std::ssize(view.ids)) continue;
    std::vector<Vector2d> residuals(view.ids.size(), Vector2d::Constant(std::nan("")));
    if (pose)
      residuals = residuals_px(fit.bundle.corrected(view.problem, rows, buffer).correspondences,
                               fit.lens(v), *pose);
    for (std::size_t i = 0; i < view.ids.size(); ++i)
      if (!is_used || !selection.inlier[v][i])
        outliers.push_back(
            {view.image, view.ids[i], residuals[i].norm(), view.index, view.corners[i]});
  }
  return outliers;
}

std::optional<CalibrationFit> fit_model(const Model& model, const CalibrationInput& input,
                                        const CalibrateOptions& options) {
  const Stopwatch stopwatch;
  const auto start = calibration_seed(model, input.image_size, input.views, seed_options(options));
  if (!start) return std::nullopt;
  const double start_seconds = stopwatch.seconds();
  Bundle bundle;
  bundle.model = &model;
  bundle.image_size = input.image_size;
  bundle.free_values = start->free_values;
  bundle.board = input.board;
  auto fit = fit_from(bundle, selection_of(*start, options), input, options);
  if (!fit) return std::nullopt;
  fit->start_seconds = start_seconds;
  fit->solve_seconds = stopwatch.seconds() - start_seconds;
  return fit;
}

CalibrationFit fit_on_inliers(CalibrationFit fit, const Model& model,
                              std::vector<double> free_values, const CalibrateOptions& options) {
  const Stopwatch stopwatch;
  const double before = fit.summary.cost;
  fit.bundle.model = &model;
  fit.bundle.free_values = std::move(free_values);
  fit.summary = solve_until_converged(fit.bundle, options.max_iterations, options.num_threads);
  fit.more_cost += fit.summary.cost - before;
  // A lower cost: the squares are those of a fit that is no minimum, and are capped where they are
  // summed, so that the difference would count for more than they do.
  if (fit.more_cost < 0 && !fit.squares.empty()) set_inlier_squares(fit);
  fit.num_iterations += fit.summary.num_iterations;
  fit.solve_seconds += stopwatch.seconds();
  return fit;
}

}  // namespace tagcal::internal
