#include "tagcal/estimate/calibration/kinds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/bundle/lens_from_rays.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/spread_indices.hpp"

namespace tagcal::internal {
namespace {

// The number of independent residuals.
double num_residuals(const Posterior& posterior) {
  return 2.0 * posterior.fit.num_corners / posterior.covariance.overdispersion;
}

// The free values of a model whose lens is nearest to a solved one where the corners are.
std::optional<std::vector<double>> nearest_values(const Model& model, const Bundle& solved) {
  const Lens lens = solved.lens();
  Sightings seen;
  for (const Eigen::Vector2d& pixel : seen_region(solved).samples())
    if (const auto ray = ray_in_camera(lens, pixel)) seen.add(pixel, ray->direction);
  const auto p = parameters(lens);
  std::vector<std::vector<double>> starts;
  if (&model.kind() == &kind_of(lens)) starts.push_back(model.free_values(lens));
  auto nearest = lens_from_rays(model, solved.image_size, seen, Eigen::Vector2d(p[kCx], p[kCy]),
                                std::move(starts));
  if (!nearest) return std::nullopt;
  return std::move(nearest->free_values);
}

// The posterior of another model on the same inliers.
std::optional<Posterior> on_inliers_of(const Posterior& solved, const Model& model,
                                       const CalibrateOptions& options) {
  auto start = nearest_values(model, solved.fit.bundle);
  if (!start) return std::nullopt;
  return posterior_of(fit_on_inliers(solved.fit, model, std::move(*start), options), options);
}

bool explains_better(const Posterior& a, const Posterior& b) {
  return chi_square(a.fit, a) < chi_square(b.fit, a);
}

// The posterior of a model that starts near the lens of another one.
std::optional<Posterior> fit_near(const Model& model, const Posterior& other,
                                  const CalibrationInput& input, const CalibrateOptions& options) {
  const auto start = nearest_values(model, other.fit.bundle);
  const auto lens = start ? model.lens(*start, input.image_size) : std::nullopt;
  return lens ? fit_posterior_from(*lens, model, input, options) : std::nullopt;
}

// All corners are within 80 degrees of the axis, so a perspective lens can see them.
bool within_perspective_field(const Bundle& bundle) {
  for (std::size_t v = 0; v < bundle.views.size(); ++v)
    for (const Correspondence& c : bundle.views[v].correspondences) {
      const Eigen::Vector3d x = bundle.camera_from_target[v] * c.point;
      if (x.z() < policy::kPerspectiveCosine * x.norm()) return false;
    }
  return true;
}

}  // namespace

double chi_square(const CalibrationFit& fit, const Posterior& noise) {
  const double sigma = noise.noise.sigma;
  const double sum = fit.truncated_chi_square(sigma) + fit.summary.prior / (sigma * sigma);
  return sum / noise.covariance.overdispersion + fit.summary.row_volume;
}

double bic(const Model& model, double chi_square, const Posterior& posterior) {
  return chi_square + model.num_free() * std::log(num_residuals(posterior));
}

std::optional<Posterior> fit_posterior(const Model& model, const CalibrationInput& input,
                                       const CalibrateOptions& options) {
  auto fit = fit_model(model, input, options);
  return fit ? posterior_of(std::move(*fit), options) : std::nullopt;
}

std::optional<Posterior> fit_posterior_from(const Lens& start, const Model& model,
                                            const CalibrationInput& input,
                                            const CalibrateOptions& options) {
  CalibrateOptions from = options;
  from.start = Camera{start, input.image_size};
  return fit_posterior(model, input, from);
}

std::vector<const Posterior*> Kinds::all() const {
  std::vector<const Posterior*> result;
  for (const auto* kind : {&polynomial, &rational, &fisheye})
    if (*kind) result.push_back(&**kind);
  for (const Posterior& sphere : spheres) result.push_back(&sphere);
  return result;
}

Kinds fit_kinds(const CalibrationInput& input, const CalibrateOptions& options) {
  Kinds kinds;
  const LensKind& perspective = kind_of<Perspective>();
  const Model& rational = input.models->of(perspective, ModelRole::largest);
  const Model& polynomial = input.models->of(perspective, ModelRole::usual);
  kinds.rational = fit_posterior(rational, input, options);
  kinds.fisheye =
      fit_posterior(input.models->of(kind_of<Fisheye>(), ModelRole::largest), input, options);
  if (kinds.fisheye && (!kinds.rational || explains_better(*kinds.fisheye, *kinds.rational))) {
    auto again = fit_near(rational, *kinds.fisheye, input, options);
    if (again && (!kinds.rational || explains_better(*again, *kinds.rational)))
      kinds.rational = std::move(again);
  }
  kinds.polynomial = kinds.rational ? on_inliers_of(*kinds.rational, polynomial, options)
                                    : fit_posterior(polynomial, input, options);
  if (kinds.fisheye && best_of(kinds) == &*kinds.fisheye)
    for (const LensKind* sphere : {&kind_of<DoubleSphere>(), &kind_of<ExtendedUnified>()})
      if (auto fit =
              on_inliers_of(*kinds.fisheye, input.models->of(*sphere, ModelRole::largest), options))
        if (explains_better(*fit, *kinds.fisheye)) kinds.spheres.push_back(std::move(*fit));
  return kinds;
}

const Posterior* best_of(const Kinds& kinds) {
  const Posterior* noise = nullptr;
  for (const Posterior* kind : kinds.all())
    if (!noise || explains_better(*kind, *noise)) noise = kind;
  if (!noise) return nullptr;
  const auto score = [&](const Posterior* p) {
    return p ? bic(p->model(), chi_square(p->fit, *noise), *noise)
             : std::numeric_limits<double>::infinity();
  };
  const Posterior *usual = nullptr, *wide = nullptr;
  for (const Posterior* kind : kinds.all()) {
    const Posterior*& best = kind->model().kind().reaches_behind ? wide : usual;
    if (!best || score(kind) < score(best)) best = kind;
  }
  const bool is_polynomial = usual && usual->model().role() == ModelRole::usual;
  const double charge =
      is_polynomial ? policy::kFisheyeCharge * std::log(num_residuals(*noise)) : 0;
  return wide && score(wide) + charge < score(usual) ? wide : usual;
}

double gain_of_perspective(const Posterior& named, const CalibrationInput& input,
                           const CalibrateOptions& options) {
  if (!named.model().kind().reaches_behind || !within_perspective_field(named.fit.bundle)) return 0;
  const CalibrationInput few = spread_views(input, policy::kChoiceViews);
  std::optional<Posterior> of_few;
  if (few.views.size() < input.views.size()) {
    of_few = fit_posterior(named.model(), few, options);
    if (!of_few) return 0;
  }
  const auto other =
      fit_posterior(input.models->of(kind_of<Perspective>(), ModelRole::usual), few, options);
  if (!other) return 0;
  const double own = chi_square((of_few ? *of_few : named).fit, *other);
  const double less = chi_square(other->fit, *other);
  return own - less > policy::kAmbiguousCost ? (own - less) / own : 0;
}

CalibrationInput without_views(const CalibrationInput& input) {
  return {input.image_size, input.models,   {},
          input.board,      input.whitened, input.model_error_px,
          input.has_rows,   input.findings, input.rejected};
}

CalibrationInput spread_views(const CalibrationInput& input, std::size_t count) {
  CalibrationInput few = without_views(input);
  for (const std::size_t v : spread_indices(input.views.size(), count))
    few.views.push_back(input.views[v]);
  return few;
}

}  // namespace tagcal::internal
