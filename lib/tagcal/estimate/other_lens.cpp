#include "tagcal/estimate/other_lens.hpp"

#include <algorithm>
#include <vector>

#include "tagcal/estimate/doubt.hpp"

namespace tagcal {
namespace {

constexpr int kIterations = 100;
constexpr std::size_t kMostViews = 20;
constexpr double kChiSquare = 25;

// Some views of a fit, evenly spread, and all of their corners.
struct SomeViews {
  Bundle bundle;
  std::vector<const ViewProblem*> all;
};

SomeViews some_views(const CalibrationFit& fit, const CalibrationInput& input) {
  const Bundle& from = fit.bundle;
  SomeViews some{{from.model, from.image_size, from.free_values, {}, {}}, {}};
  const std::size_t n = from.views.size(), count = std::min(n, kMostViews);
  auto next = input.views.begin();
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t v = i * n / count;
    next = std::find_if(next, input.views.end(),
                        [&](const CalibrationView& view) { return view.image == fit.images[v]; });
    if (next == input.views.end()) break;
    some.bundle.views.push_back(from.views[v]);
    some.bundle.camera_from_target.push_back(from.camera_from_target[v]);
    some.all.push_back(&next->problem);
  }
  return some;
}

// Squared residuals of all corners in units of the noise, each up to the bound of rejection.
double misfit(const Bundle& bundle, const SomeViews& some, double sigma) {
  const Lens lens = bundle.lens();
  double sum = 0;
  for (std::size_t v = 0; v < some.all.size(); ++v)
    for (const double square : whitened_squares(*some.all[v], lens, bundle.camera_from_target[v]))
      sum += std::min(square / (sigma * sigma), kRejectSigmas * kRejectSigmas);
  return sum;
}

// Solved on those of all corners that agree with it.
Bundle solved_again(Bundle bundle, const SomeViews& some, const Bundle& judge, double sigma) {
  const Lens lens = judge.lens();
  for (std::size_t v = 0; v < some.all.size(); ++v) {
    std::vector<std::uint8_t> inlier;
    for (const double square : whitened_squares(*some.all[v], lens, judge.camera_from_target[v]))
      inlier.push_back(square <= kRejectSigmas * kRejectSigmas * sigma * sigma);
    ViewProblem agreeing = chosen(*some.all[v], inlier);
    if (agreeing.correspondences.size() >= 4) bundle.views[v] = std::move(agreeing);
  }
  solve(bundle, kIterations);
  return bundle;
}

}  // namespace

std::optional<std::string> instead_of_fisheye(const CalibrationFit& fit,
                                              const CalibrationInput& input, double sigma) {
  if (fit.bundle.model->lens_type() != LensType::fisheye || !well_in_front(fit.bundle))
    return std::nullopt;
  const SomeViews some = some_views(fit, input);
  Bundle other = with_model(some.bundle, Model::named("f"));
  solve(other, kIterations);
  other = with_model(other, Model::named("opencv5"));
  if (!solve(other, kIterations).converged) return std::nullopt;
  other = solved_again(other, some, other, sigma);
  double own = misfit(some.bundle, some, sigma);
  const double least = misfit(other, some, sigma);
  if (own - least < kChiSquare) return std::nullopt;
  // Corners that the fisheye lost on its way do not speak for the other.
  own = std::min(own, misfit(solved_again(some.bundle, some, other, sigma), some, sigma));
  if (own - least < kChiSquare) return std::nullopt;
  return "the model is too small: opencv5 would explain " + percent((own - least) / own) +
         " of the squares of its residuals";
}

}  // namespace tagcal
