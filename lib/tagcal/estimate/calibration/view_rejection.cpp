#include "tagcal/estimate/calibration/view_rejection.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

constexpr double kSeveralTimes = 1.3;  // the median RMS
constexpr std::size_t kFewestViews = 4;

// A view as a fit sees it.
struct FittedView {
  std::size_t view = 0;  // of the input
  Pose camera_from_world;
  std::vector<std::uint8_t> inlier;
  std::size_t num_inliers = 0;
  double rms = 0;                      // of the inliers' whitened residuals
  std::size_t seed = 0, seed_out = 0;  // corners of the view's largest board, and rejected of them

  double share_out() const {
    return static_cast<double>(seed_out) / static_cast<double>(std::max<std::size_t>(1, seed));
  }
  std::size_t others() const { return inlier.size() - seed; }
  std::size_t others_out() const { return inlier.size() - num_inliers - seed_out; }
  // Boards beside the largest that do not agree with it.
  bool has_moved_board() const {
    return others() >= 4 && 2 * others_out() > others() && 3 * seed_out < seed;
  }
};

bool is_outlier(const std::vector<Outlier>& outliers, std::size_t next, std::size_t view,
                std::size_t corner) {
  return next < outliers.size() && outliers[next].view == view && outliers[next].corner == corner;
}

// Squares and outliers of a fit stand in the order of the input's corners.
std::vector<FittedView> fitted_views(const CalibrationInput& input, const CalibrationFit& fit) {
  std::vector<FittedView> result;
  std::size_t square = 0, out = 0, taken = 0;
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    FittedView view;
    view.view = v;
    double sum = 0;
    for (const std::size_t corner : input.views[v].corners) {
      const bool outlier = is_outlier(fit.outliers, out, input.views[v].index, corner);
      view.inlier.push_back(!outlier);
      if (!outlier) sum += fit.squares[square];
      ++square;
      out += outlier;
    }
    if (taken == fit.views.size() || fit.views[taken] != input.views[v].index) continue;
    view.camera_from_world = fit.bundle.camera_from_target[taken++];
    view.num_inliers =
        static_cast<std::size_t>(std::count(view.inlier.begin(), view.inlier.end(), 1));
    view.seed = input.views[v].seed.size();
    for (const std::size_t i : input.views[v].seed) view.seed_out += !view.inlier[i];
    view.rms = std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, view.num_inliers)));
    result.push_back(std::move(view));
  }
  return result;
}

// Whether the residuals of all corners of a view, or of its inliers, go together.
bool goes_together(const FittedView& fitted, const CalibrationView& view, const Lens& lens,
                   bool inliers_only) {
  const auto& correspondences = view.problem.correspondences;
  const auto all = residuals_px(correspondences, lens, fitted.camera_from_world);
  std::vector<Vector2d> pixels, residuals;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!all[i].allFinite() || (inliers_only && !fitted.inlier[i])) continue;
    pixels.push_back(correspondences[i].pixel);
    residuals.push_back(all[i]);
  }
  return go_together(pixels, residuals);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// What a view of this fit is like: medians.
struct UsualView {
  double rms = 0;
  double share_out = 0;  // of the largest board's corners, rejected
};

UsualView usual_view(const std::vector<FittedView>& views, double least_sigma) {
  std::vector<double> rms, share;
  for (const FittedView& view : views) {
    rms.push_back(view.rms);
    share.push_back(view.share_out());
  }
  return {std::max(median(rms), std::sqrt(2) * least_sigma), median(share)};
}

bool stands_out(const FittedView& fitted, const CalibrationView& view, const Lens& lens,
                const UsualView& usual) {
  if (fitted.rms > kSeveralTimes * usual.rms && goes_together(fitted, view, lens, true))
    return true;
  const double more_out = fitted.share_out() - usual.share_out;
  if (more_out > 0.4) return true;
  return more_out > 0.3 && goes_together(fitted, view, lens, false);
}

// Residuals that go together in view after view are those of a model or a target, not of a view.
bool model_is_wrong(const std::vector<FittedView>& views, const CalibrationInput& input,
                    const Lens& lens) {
  const auto count = std::count_if(views.begin(), views.end(), [&](const FittedView& v) {
    return goes_together(v, input.views[v.view], lens, true);
  });
  return 3 * static_cast<std::size_t>(count) > views.size();
}

// The views that stand out, in ascending order.
std::vector<const FittedView*> wrong_views(const std::vector<FittedView>& views,
                                           const CalibrationInput& input, const Lens& lens,
                                           double least_sigma) {
  if (views.size() < kFewestViews) return {};
  const UsualView usual = usual_view(views, least_sigma);
  std::vector<const FittedView*> wrong;
  for (const FittedView& view : views)
    if (stands_out(view, input.views[view.view], lens, usual)) wrong.push_back(&view);
  const bool none = wrong.empty() || 3 * wrong.size() > views.size();
  if (none || model_is_wrong(views, input, lens)) return {};
  return wrong;
}

void drop(CalibrationInput& input, const CalibrationView& view, std::size_t corner,
          const Vector2d& residual) {
  input.dropped.push_back(
      {view.image, view.ids[corner], residual.norm(), view.index, view.corners[corner]});
}

// Keeps the largest board of a view.
void leave_out_others(CalibrationInput& input, const FittedView& fitted, const Lens& lens) {
  CalibrationView& view = input.views[fitted.view];
  const auto residuals = residuals_px(view.problem.correspondences, lens, fitted.camera_from_world);
  CalibrationView kept;
  kept.image = view.image;
  kept.index = view.index;
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    if (!std::binary_search(view.seed.begin(), view.seed.end(), i)) {
      drop(input, view, i, residuals[i]);
      continue;
    }
    kept.seed.push_back(kept.ids.size());
    kept.ids.push_back(view.ids[i]);
    kept.corners.push_back(view.corners[i]);
    kept.problem.correspondences.push_back(view.problem.correspondences[i]);
    if (input.whitened) kept.problem.whitening.push_back(view.problem.whitening[i]);
  }
  input.warnings.push_back(view.name() +
                           ": one board only takes part, the others do not hang where they should");
  view = std::move(kept);
}

void leave_out_view(CalibrationInput& input, const FittedView& fitted, const Lens& lens) {
  const auto at = input.views.begin() + static_cast<std::ptrdiff_t>(fitted.view);
  const auto residuals = residuals_px(at->problem.correspondences, lens, fitted.camera_from_world);
  for (std::size_t i = 0; i < residuals.size(); ++i) drop(input, *at, i, residuals[i]);
  input.warnings.push_back(
      at->name() +
      ": left out, its residuals are larger than those of the other views and "
      "correlated: camera or board moved during the exposure, or the board was bent");
  input.views.erase(at);
}

}  // namespace

bool leave_out_what_stands_out(CalibrationInput& input, const CalibrationFit& fit,
                               const CalibrateOptions& options) {
  const std::vector<FittedView> views = fitted_views(input, fit);
  const Lens lens = fit.bundle.lens();
  bool any = false;
  for (const FittedView& view : views) {
    if (!view.has_moved_board()) continue;
    leave_out_others(input, view, lens);
    any = true;
  }
  if (any) return true;
  const std::vector<const FittedView*> wrong =
      wrong_views(views, input, lens, least_sigma(input.whitened, options));
  for (auto w = wrong.rbegin(); w != wrong.rend(); ++w) {  // from the last: indices stay
    if ((*w)->others() > 0)
      leave_out_others(input, **w, lens);  // the largest board may be right
    else
      leave_out_view(input, **w, lens);
  }
  return !wrong.empty();
}

bool explains_left_out(const CalibrationFit& fit, const CalibrationInput& without,
                       const CalibrateOptions& options) {
  constexpr double kNormalQuantile = 3.09;  // p = 0.001
  if (fit.num_inliers() < fit.num_corners) return false;
  const std::optional<CalibrationFit> rest = fit_model(*fit.bundle.model, without, options);
  if (!rest) return false;
  const int freedom = degrees_of_freedom(rest->bundle),
            more = degrees_of_freedom(fit.bundle) - freedom;
  if (freedom < kEnoughDegreesOfFreedom || more <= 0) return false;
  const double square = rest->summary.cost / freedom;
  return fit.summary.cost - rest->summary.cost <=
         square * chi_square_quantile(more, kNormalQuantile);
}

}  // namespace tagcal::internal
