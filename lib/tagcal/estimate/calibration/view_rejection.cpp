#include "tagcal/estimate/calibration/view_rejection.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

// A view under a fit.
struct FittedView {
  std::size_t view = 0;  // index in the input
  Pose camera_from_world;
  Vector6d row_terms = Vector6d::Zero();
  std::vector<std::uint8_t> inlier;
  std::size_t num_inliers = 0;
  double rms = 0;                 // of the inliers' whitened residuals
  std::size_t seed = 0;           // corners of the view's largest board
  std::size_t seed_rejected = 0;  // and the outliers among them

  double rejected_share() const {
    return static_cast<double>(seed_rejected) / static_cast<double>(std::max<std::size_t>(1, seed));
  }
  std::size_t others() const { return inlier.size() - seed; }
  std::size_t others_rejected() const { return inlier.size() - num_inliers - seed_rejected; }
  // The boards beside the largest one have moved against it.
  bool has_moved_board() const {
    return others() >= policy::kLeastViewCorners && 2 * others_rejected() > others() &&
           policy::is_below(seed_rejected, policy::kMinority, seed);
  }
};

std::vector<FittedView> fitted_views(const CalibrationInput& input, const CalibrationFit& fit) {
  std::vector<FittedView> result;
  for (std::size_t i = 0; i < fit.used.size(); ++i) {
    FittedView view;
    view.view = fit.used[i];
    view.inlier = fit.selection.inlier[view.view];
    view.camera_from_world = fit.bundle.camera_from_target[i];
    if (!fit.bundle.row_terms.empty()) view.row_terms = fit.bundle.row_terms[i];
    view.num_inliers = static_cast<std::size_t>(fit.selection.num_inliers(view.view));
    view.seed = input.views[view.view].seed.size();
    for (const std::size_t corner : input.views[view.view].seed)
      view.seed_rejected += !view.inlier[corner];
    double sum = 0;
    for (std::size_t k = 0; k < view.inlier.size(); ++k)
      if (view.inlier[k]) sum += fit.squares[view.view][k];
    view.rms = std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, view.num_inliers)));
    result.push_back(std::move(view));
  }
  return result;
}

std::vector<Vector2d> residuals_of(const FittedView& fitted, const CalibrationView& view,
                                   const Bundle& bundle) {
  ViewProblem buffer;
  return residuals_px(bundle.corrected(view.problem, fitted.row_terms, buffer).correspondences,
                      bundle.lens(), fitted.camera_from_world);
}

// The residuals of a view's inliers are spatially correlated.
bool is_spatially_correlated(const FittedView& fitted, const CalibrationView& view,
                             const Bundle& bundle) {
  const auto& correspondences = view.problem.correspondences;
  const auto all = residuals_of(fitted, view, bundle);
  std::vector<Vector2d> pixels, residuals;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!fitted.inlier[i]) continue;
    pixels.push_back(correspondences[i].pixel);
    residuals.push_back(all[i]);
  }
  return spatially_correlated(pixels, residuals);
}

// Medians over the views of a fit.
struct MedianView {
  double rms = 0;
  double rejected_share = 0;
};

MedianView median_view(const std::vector<FittedView>& views, double least_sigma) {
  std::vector<double> rms, share;
  for (const FittedView& view : views) {
    rms.push_back(view.rms);
    share.push_back(view.rejected_share());
  }
  return {std::max(median(rms), std::sqrt(2) * least_sigma), median(share)};
}

bool is_outlying(const FittedView& fitted, const CalibrationView& view, const Bundle& bundle,
                 const MedianView& usual) {
  if (fitted.rms > policy::kMuchLargerSd * usual.rms &&
      is_spatially_correlated(fitted, view, bundle))
    return true;
  return fitted.rejected_share() - usual.rejected_share > policy::kMinority.value();
}

// Spatially correlated residuals in many views come from the model or the target.
bool is_model_wrong(const std::vector<FittedView>& views, const CalibrationInput& input,
                    const Bundle& bundle) {
  const auto count = std::count_if(views.begin(), views.end(), [&](const FittedView& v) {
    return is_spatially_correlated(v, input.views[v.view], bundle);
  });
  return policy::is_above(static_cast<std::size_t>(count), policy::kMinority, views.size());
}

// The outlying views, in ascending order.
std::vector<const FittedView*> outlying_views(const std::vector<FittedView>& views,
                                              const CalibrationInput& input, const Bundle& bundle,
                                              double least_sigma) {
  if (std::ssize(views) < policy::kFewestTellingViews) return {};
  const MedianView usual = median_view(views, least_sigma);
  std::vector<const FittedView*> outlying;
  for (const FittedView& view : views)
    if (is_outlying(view, input.views[view.view], bundle, usual)) outlying.push_back(&view);
  if (outlying.empty() || policy::is_above(outlying.size(), policy::kMinority, views.size()) ||
      is_model_wrong(views, input, bundle))
    return {};
  return outlying;
}

void reject_corner(CalibrationInput& input, const CalibrationView& view, std::size_t corner,
                   const Vector2d& residual) {
  input.rejected.push_back(
      {view.image, view.ids[corner], residual.norm(), view.index, view.corners[corner]});
}

// Keeps the largest board of a view.
void reject_other_boards(CalibrationInput& input, const FittedView& fitted, const Bundle& bundle) {
  CalibrationView& view = input.views[fitted.view];
  const auto residuals = residuals_of(fitted, view, bundle);
  CalibrationView kept;
  kept.image = view.image;
  kept.index = view.index;
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    if (!std::binary_search(view.seed.begin(), view.seed.end(), i)) {
      reject_corner(input, view, i, residuals[i]);
      continue;
    }
    kept.seed.push_back(static_cast<std::uint32_t>(kept.ids.size()));
    kept.ids.push_back(view.ids[i]);
    kept.corners.push_back(view.corners[i]);
    kept.problem.correspondences.push_back(view.problem.correspondences[i]);
    if (input.whitened) kept.problem.whitening.push_back(view.problem.whitening[i]);
  }
  add(input.findings, code::board_moved,
      view.name() +
          ": only its largest board is used, the other boards are not at their poses in the target "
          "file");
  view = std::move(kept);
}

void reject_view(CalibrationInput& input, const FittedView& fitted, const Bundle& bundle) {
  const auto at = input.views.begin() + static_cast<std::ptrdiff_t>(fitted.view);
  const auto residuals = residuals_of(fitted, *at, bundle);
  for (std::size_t i = 0; i < residuals.size(); ++i) reject_corner(input, *at, i, residuals[i]);
  add(input.findings, code::view_rejected,
      at->name() +
          ": rejected, its residuals are larger than those of the other views and "
          "correlated: camera or board moved during the exposure, or the board was bent");
  input.views.erase(at);
}

}  // namespace

bool reject_outlying_views(CalibrationInput& input, const CalibrationFit& fit,
                           const CalibrateOptions& options) {
  const std::vector<FittedView> views = fitted_views(input, fit);
  bool any = false;
  for (const FittedView& view : views) {
    if (!view.has_moved_board()) continue;
    reject_other_boards(input, view, fit.bundle);
    any = true;
  }
  if (any) return true;
  const std::vector<const FittedView*> outlying =
      outlying_views(views, input, fit.bundle, least_sigma(input.whitened, options));
  for (auto w = outlying.rbegin(); w != outlying.rend(); ++w) {  // backwards: indices stay valid
    if ((*w)->others() > 0)
      reject_other_boards(input, **w, fit.bundle);  // the largest board may be right
    else
      reject_view(input, **w, fit.bundle);
  }
  return !outlying.empty();
}

}  // namespace tagcal::internal
