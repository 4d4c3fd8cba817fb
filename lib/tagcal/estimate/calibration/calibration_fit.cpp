#include "tagcal/estimate/calibration/calibration_fit.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/held_parameters.hpp"
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

// Which corners take part, and the pose of each view (none: the view takes no part).
struct Selection {
  std::vector<std::optional<Pose>> pose;
  std::vector<std::vector<std::uint8_t>> inlier;
};

// The bundle of the selected corners; `views` says where its views are in the input.
Bundle select(const Bundle& base, const CalibrationInput& input, const Selection& selection,
              std::vector<std::size_t>& views) {
  Bundle bundle{base.model, base.image_size, base.free_values, {}, {}};
  views.clear();
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    const auto count = std::count(selection.inlier[v].begin(), selection.inlier[v].end(), 1);
    if (!selection.pose[v] || count < 4) continue;
    bundle.views.push_back(chosen(input.views[v].problem, selection.inlier[v]));
    bundle.camera_from_target.push_back(*selection.pose[v]);
    views.push_back(v);
  }
  return bundle;
}

// Squared whitened residuals of every corner under a lens and the selection's poses.
std::vector<std::vector<double>> all_squares(const Lens& lens, const CalibrationInput& input,
                                             const Selection& selection) {
  std::vector<std::vector<double>> squares(input.views.size());
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    const ViewProblem& view = input.views[v].problem;
    if (selection.pose[v])
      squares[v] = whitened_squares(view, lens, *selection.pose[v]);
    else
      squares[v].assign(view.correspondences.size(), kInfinity);
  }
  return squares;
}

// A robust standard deviation of the selected corners' coordinates.
double robust_sigma(const std::vector<std::vector<double>>& squares, const Selection& selection) {
  std::vector<double> taken;
  for (std::size_t v = 0; v < squares.size(); ++v)
    for (std::size_t i = 0; i < squares[v].size(); ++i)
      if (selection.inlier[v][i] && std::isfinite(squares[v][i])) taken.push_back(squares[v][i]);
  return taken.empty() ? kInfinity : std::sqrt(robust_variance(taken));
}

// Corners within `bound` standard deviations; says whether any changed sides.
bool reselect(const std::vector<std::vector<double>>& squares, double bound, Selection& selection) {
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

// A view that lost most of its corners may only have started badly, from a lens far from the one
// that is known now: it gets a new pose where more corners agree with that. Says whether any did.
bool rescue_views(const CalibrationInput& input, const Lens& lens, double bound,
                  Selection& selection) {
  bool any = false;
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    const auto count = std::count(selection.inlier[v].begin(), selection.inlier[v].end(), 1);
    if (2 * count > static_cast<std::ptrdiff_t>(selection.inlier[v].size())) continue;
    const std::optional<Pose> pose = consensus_pose(input.views[v], lens);
    if (!pose) continue;
    int agreeing = 0;
    for (const Vector2d& r : residuals_px(input.views[v].problem.correspondences, lens, *pose))
      agreeing += r.norm() <= bound;
    if (agreeing <= count) continue;
    selection.pose[v] = pose;
    any = true;
  }
  return any;
}

void drop_outside_domain(const Bundle& bundle, const CalibrationInput& input,
                         Selection& selection) {
  const auto squares = all_squares(bundle.lens(), input, selection);
  for (std::size_t v = 0; v < squares.size(); ++v)
    for (std::size_t i = 0; i < squares[v].size(); ++i)
      if (!std::isfinite(squares[v][i])) selection.inlier[v][i] = 0;
}

void list_outliers(const CalibrationInput& input, const Selection& selection,
                   const std::vector<std::vector<double>>& squares, CalibrationFit& fit) {
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    const CalibrationView& view = input.views[v];
    fit.num_corners += static_cast<int>(view.ids.size());
    fit.squares.insert(fit.squares.end(), squares[v].begin(), squares[v].end());
    const auto count = std::count(selection.inlier[v].begin(), selection.inlier[v].end(), 1);
    const bool taken = selection.pose[v] && count >= 4;
    if (!taken) fit.warnings.push_back(view.name() + ": left out, its corners do not agree");
    std::vector<Vector2d> residuals;
    if (selection.pose[v])
      residuals = residuals_px(view.problem.correspondences, fit.bundle.lens(), *selection.pose[v]);
    for (std::size_t i = 0; i < view.ids.size(); ++i)
      if (!taken || !selection.inlier[v][i])
        fit.outliers.push_back(
            {view.image, view.ids[i],
             residuals.empty() ? std::numeric_limits<double>::quiet_NaN() : residuals[i].norm(),
             view.index, view.corners[i]});
  }
}

// A bundle on the corners that agree with it.
struct Settled {
  Bundle bundle;
  Selection selection;
  BundleSummary summary;
  std::vector<std::size_t> used;             // the bundle's views in the input
  std::vector<std::vector<double>> squares;  // of every corner
  double sigma = 0;                          // robust; corners further than five of it are out
};

// Solves and selects in turn, until no corner changes sides.
void settle_selection(const CalibrationInput& input, const CalibrateOptions& options,
                      CalibrationFit& fit, Settled& state) {
  for (int round = 0; round < kMaxRounds; ++round) {
    drop_outside_domain(state.bundle, input, state.selection);
    state.bundle = select(state.bundle, input, state.selection, state.used);
    if (state.bundle.views.empty()) return;
    state.summary = solve(state.bundle, options.max_iterations, options.num_threads);
    fit.num_iterations += state.summary.num_iterations;
    for (std::size_t i = 0; i < state.used.size(); ++i)
      state.selection.pose[state.used[i]] = state.bundle.camera_from_target[i];
    state.squares = all_squares(state.bundle.lens(), input, state.selection);
    if (!options.reject_outliers) return;
    state.sigma = std::max(least_sigma(input.whitened, options),
                           robust_sigma(state.squares, state.selection));
    if (!reselect(state.squares, kRejectSigmas * state.sigma, state.selection)) return;
  }
}

// The squares of all corners, each up to a bound.
double truncated_loss(const std::vector<std::vector<double>>& squares, double bound) {
  double sum = 0;
  for (const auto& of_view : squares)
    for (const double square : of_view) sum += std::min(square, bound * bound);
  return sum;
}

// Corners that are out by some times the bound may be right, and out because the lens was fitted
// without them, where it is free: it is fitted with them, and whichever explains all corners better
// is kept. (A lens between two groups that contradict each other leaves larger residuals.)
void reconsider(const CalibrationInput& input, const CalibrateOptions& options, CalibrationFit& fit,
                Settled& state) {
  constexpr double kAsLarge = 1.05;
  for (const double times : {2.0, 8.0, kInfinity}) {
    const double bound = kRejectSigmas * state.sigma;
    Selection wider = state.selection;
    if (!reselect(state.squares, times * bound, wider)) continue;
    Settled other = state;
    other.selection = std::move(wider);
    settle_selection(input, options, fit, other);
    if (other.bundle.views.empty() || (state.summary.converged && !other.summary.converged))
      continue;
    if (other.sigma < kAsLarge * state.sigma &&
        truncated_loss(other.squares, bound) < truncated_loss(state.squares, bound))
      state = std::move(other);
  }
}

void run_rounds(const CalibrationInput& input, const CalibrateOptions& options, CalibrationFit& fit,
                Selection selection) {
  Settled state{std::move(fit.bundle), std::move(selection), {}, {}, {}, 0};
  settle_selection(input, options, fit, state);
  if (options.reject_outliers && !state.bundle.views.empty()) {
    const Lens lens = state.bundle.lens();
    const double wide = 2 * kRejectSigmas * state.sigma;
    if (rescue_views(input, lens, wide, state.selection)) {
      reselect(all_squares(lens, input, state.selection), wide, state.selection);
      settle_selection(input, options, fit, state);
    }
    reconsider(input, options, fit, state);
  }
  fit.bundle = std::move(state.bundle);
  fit.summary = state.summary;
  if (fit.bundle.views.empty())
    state.squares = all_squares(fit.bundle.lens(), input, state.selection);
  for (const std::size_t v : state.used) {
    fit.views.push_back(input.views[v].index);
    fit.images.push_back(input.views[v].image);
  }
  list_outliers(input, state.selection, state.squares, fit);
}

}  // namespace

int CalibrationFit::num_inliers() const { return internal::num_corners(bundle); }

double CalibrationFit::truncated_misfit(double sigma) const {
  double sum = 0;
  for (const double square : squares)
    sum += std::min(square / (sigma * sigma), kRejectSigmas * kRejectSigmas);
  return sum;
}

std::optional<CalibrationFit> fit_model(const Model& model, const CalibrationInput& input,
                                        const CalibrateOptions& options) {
  const auto begin = Clock::now();
  const auto start = find_start(model, input.image_size, input.views, start_options(options));
  if (!start) return std::nullopt;
  CalibrationFit fit;
  fit.bundle = Bundle{&model, input.image_size, start->free_values, {}, {}};
  fit.whitened = input.whitened;
  fit.warnings = input.warnings;
  fit.start_seconds = seconds_since(begin);
  Selection selection{start->camera_from_world, start->inlier};
  if (!options.reject_outliers)
    for (auto& view : selection.inlier) std::fill(view.begin(), view.end(), 1);
  run_rounds(input, options, fit, selection);
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
  std::set<std::pair<std::size_t, std::size_t>> out;
  for (const Outlier& o : other.outliers) out.emplace(o.view, o.corner);
  Selection selection;
  for (const CalibrationView& view : input.views) {
    const auto pose = poses.find(view.index);
    selection.pose.push_back(pose == poses.end() ? std::nullopt : std::optional(pose->second));
    auto& inlier = selection.inlier.emplace_back();
    for (const std::size_t i : view.corners) inlier.push_back(!out.contains({view.index, i}));
  }
  CalibrationFit fit{
      {solved.model, solved.image_size, solved.free_values, {}, {}}, {}, {}, input.whitened};
  fit.warnings = input.warnings;
  run_rounds(input, options, fit, selection);
  if (fit.bundle.views.empty()) return std::nullopt;
  return fit;
}

}  // namespace tagcal::internal
