#include "tagcal/estimate/calibration/alternative_lens_test.hpp"

#include <algorithm>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/calibration/simpler_model_test.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

constexpr int kIterations = 100;

bool is_wide(const Bundle& bundle, const CalibrationInput& input) {
  const Lens lens = bundle.lens();
  const auto p = parameters(lens);
  const Eigen::Vector2d centre(p[kCx], p[kCy]);
  for (const CalibrationView& view : input.views)
    for (const Correspondence& c : view.problem.correspondences)
      if ((c.pixel - centre).norm() > policy::kWideFocalLengths * p[kFx]) return true;
  return false;
}

// A fit of another kind of lens that starts from the poses and the inliers of `fit`.
std::optional<CalibrationFit> fit_from(const CalibrationFit& fit, const Model& model,
                                       const CalibrationInput& input,
                                       const CalibrateOptions& options) {
  Bundle bundle = with_model(fit.bundle, fit.bundle.model->sibling("f"));
  if (model.lens_type() == LensType::perspective) solve(bundle, kIterations);
  bundle = with_model(bundle, model);
  if (!solve(bundle, kIterations).converged) return std::nullopt;
  return refit(bundle, fit, input, options);
}

}  // namespace

CalibrationInput spread_views(const CalibrationInput& input, std::size_t count) {
  const std::size_t n = input.views.size();
  if (n <= count) return input;
  CalibrationInput few{input.image_size, input.models,   {},
                       input.bent_board, input.whitened, input.model_error_px};
  for (std::size_t i = 0; i < count; ++i) few.views.push_back(input.views[i * n / count]);
  return few;
}

std::optional<AlternativeLens> alternative_lens(const CalibrationFit& fit,
                                                const CalibrationInput& input) {
  const bool is_fisheye = fit.bundle.model->lens_type() == LensType::fisheye;
  if (is_fisheye ? !within_perspective_field(fit.bundle) : !is_wide(fit.bundle, input))
    return std::nullopt;
  return AlternativeLens{fit, spread_views(input, policy::kChoiceViews),
                         input.views.size() <= policy::kChoiceViews};
}

std::optional<std::string> alternative_lens_test(const AlternativeLens& alternative,
                                                 const CalibrateOptions& options, double sigma) {
  std::optional<CalibrationFit> own = alternative.fit;
  if (!alternative.all_views)
    own = refit(alternative.fit.bundle, alternative.fit, alternative.input, options);
  if (!own) return std::nullopt;
  const bool is_fisheye = own->bundle.model->lens_type() == LensType::fisheye;
  const Model& model = own->bundle.model->sibling(is_fisheye ? "opencv5" : "fisheye4");
  const auto other = fit_from(*own, model, alternative.input, options);
  if (!other) return std::nullopt;
  const double other_chi_square = other->truncated_chi_square(sigma);
  const double chi_square = own->truncated_chi_square(sigma);
  if (chi_square - other_chi_square < policy::kOtherLensChiSquare) return std::nullopt;
  return std::string(model.name()) + ", another kind of lens, would explain " +
         percent((chi_square - other_chi_square) / chi_square) +
         " of the sum of the squared residuals: take it, or auto";
}

}  // namespace tagcal::internal
