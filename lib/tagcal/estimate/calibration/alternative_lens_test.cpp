#include "tagcal/estimate/calibration/alternative_lens_test.hpp"

#include <algorithm>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/calibration/simpler_model_test.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

constexpr int kIterations = 100;
constexpr std::size_t kMostViews = 20;
constexpr double kChiSquare = 16;
constexpr double kWide = 0.9;  // focal lengths from the principal point

bool is_wide(const Bundle& bundle, const CalibrationInput& input) {
  const Lens lens = bundle.lens();
  const auto p = parameters(lens);
  const Eigen::Vector2d centre(p[kCx], p[kCy]);
  for (const CalibrationView& view : input.views)
    for (const Correspondence& c : view.problem.correspondences)
      if ((c.pixel - centre).norm() > kWide * p[kFx]) return true;
  return false;
}

// A lens of the other kind, from the poses and the corners of a fit.
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

std::optional<LensQuestion> question_of_lens(const CalibrationFit& fit,
                                             const CalibrationInput& input) {
  const bool is_fisheye = fit.bundle.model->lens_type() == LensType::fisheye;
  if (is_fisheye ? !well_in_front(fit.bundle) : !is_wide(fit.bundle, input)) return std::nullopt;
  const std::size_t n = input.views.size(), count = std::min(n, kMostViews);
  LensQuestion question{fit, {}, count == n};
  question.input.image_size = input.image_size;
  question.input.models = input.models;
  question.input.whitened = input.whitened;
  question.input.model_error_px = input.model_error_px;
  for (std::size_t i = 0; i < count; ++i)  // evenly spread
    question.input.views.push_back(input.views[i * n / count]);
  return question;
}

std::optional<std::string> better_other_lens(const LensQuestion& question,
                                             const CalibrateOptions& options, double sigma) {
  std::optional<CalibrationFit> own = question.fit;
  if (!question.all_views) own = refit(question.fit.bundle, question.fit, question.input, options);
  if (!own) return std::nullopt;
  const bool is_fisheye = own->bundle.model->lens_type() == LensType::fisheye;
  const Model& model = own->bundle.model->sibling(is_fisheye ? "opencv5" : "fisheye4");
  const auto other = fit_from(*own, model, question.input, options);
  if (!other) return std::nullopt;
  const double least = other->truncated_misfit(sigma);
  double squares = own->truncated_misfit(sigma);
  if (squares - least < kChiSquare) return std::nullopt;
  // Corners that the own lens lost on its way do not speak for the other.
  const auto again = fit_from(*other, *own->bundle.model, question.input, options);
  if (again) squares = std::min(squares, again->truncated_misfit(sigma));
  if (squares - least < kChiSquare) return std::nullopt;
  return "the model is too small: " + std::string(model.name()) + " would explain " +
         percent((squares - least) / squares) + " of the squares of its residuals";
}

}  // namespace tagcal::internal
