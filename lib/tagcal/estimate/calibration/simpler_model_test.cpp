#include "tagcal/estimate/calibration/simpler_model_test.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/calibration/calibration_seed.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

constexpr int kIterations = 100;
constexpr std::size_t kFewViews = 8;

// Indices of at most `count` of n views, evenly spread.
std::vector<std::size_t> spread_indices(std::size_t n, std::size_t count) {
  std::vector<std::size_t> indices(std::min(n, count));
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = i * n / indices.size();
  return indices;
}

Bundle spread_views(const Bundle& bundle, std::size_t count) {
  Bundle spread = bundle.without_views();
  for (const std::size_t v : spread_indices(bundle.views.size(), count)) {
    spread.views.push_back(bundle.views[v]);
    spread.camera_from_target.push_back(bundle.camera_from_target[v]);
  }
  return spread;
}

// The views under model f: with the same poses, or with those of calibration_seed if a fisheye sees
// corners that a perspective cannot. No value if a view gets no pose.
std::optional<Bundle> with_model_f(const Bundle& bundle) {
  const Model& model = bundle.model->sibling("f");
  Bundle plain = with_model(bundle, model);
  if (within_perspective_field(bundle)) return plain;
  std::vector<CalibrationView> views;
  for (const ViewProblem& problem : bundle.views) {
    CalibrationView& view = views.emplace_back();
    view.problem = problem;
    for (std::size_t i = 0; i < problem.correspondences.size(); ++i) {
      view.ids.push_back({static_cast<int>(i), 0});
      view.seed.push_back(static_cast<std::uint32_t>(i));
    }
  }
  const auto start = calibration_seed(model, bundle.image_size, views);
  if (!start) return std::nullopt;
  plain.free_values = start->free_values;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!start->camera_from_world[v]) return std::nullopt;
    plain.camera_from_target[v] = *start->camera_from_world[v];
  }
  return plain;
}

// The fit of a lens without distortion.
struct PlainFit {
  Observability refused;        // not ok: the plain lens explains the corners and is not observable
  std::optional<Bundle> plain;  // f+c or pinhole, if it explains the corners
  double excess = 0;            // its cost above that of the full model

  bool explains() const { return refused.status != Status::ok || plain; }
};

// `most`: the excess up to which a plain lens explains the corners as well.
PlainFit fit_plain_lens(const Bundle& solved, double sigma, double most) {
  PlainFit fit;
  std::optional<Bundle> state = with_model_f(solved);
  if (!state) return fit;
  const double cost = cost_of(solved);
  fit.excess = solve(*state, kIterations).cost - cost;
  Observability seen = observability(*state, sigma);
  if (seen.status == Status::focal_not_observable && fit.excess < most) {
    fit.refused = std::move(seen);
    return fit;
  }
  const Model& plain = solved.model->sibling(solved.model->num_free() > 5 ? "pinhole" : "f+c");
  if (solved.model->num_free() <= plain.num_free()) return fit;
  state = with_model(*state, plain);
  fit.excess = solve(*state, kIterations).cost - cost;
  if (fit.excess > most) return fit;
  seen = observability(*state, sigma);
  if (seen.status != Status::ok) fit.refused = std::move(seen);
  fit.plain = std::move(state);
  return fit;
}

// Squared Mahalanobis distance between the plain and the solved lens, over the parameters that both
// have.
double distance_square(const Bundle& plain, const Bundle& solved,
                       const Eigen::MatrixXd& covariance) {
  std::vector<Eigen::Index> common;  // indices in the solved model
  std::vector<double> differences;
  for (std::size_t i = 0; i < plain.free_values.size(); ++i) {
    for (std::size_t j = 0; j < solved.free_values.size(); ++j) {
      if (plain.model->free()[i].lens_parameters[0] != solved.model->free()[j].lens_parameters[0])
        continue;
      common.push_back(static_cast<Eigen::Index>(j));
      differences.push_back(plain.free_values[i] - solved.free_values[j]);
    }
  }
  const Eigen::Map<const Eigen::VectorXd> difference(differences.data(),
                                                     static_cast<Eigen::Index>(differences.size()));
  const auto inverse = exact_inverse(covariance(common, common));
  return inverse ? difference.dot(*inverse * difference) : 0;
}

// The part of a large model's information that belongs to a model nested in it: with the matrix P
// of its parameters' effect on those of the large one, P' S P. The bends of a board stay as they
// are.
BundleInformation restricted(const BundleInformation& information, const Model& large,
                             const Model& model) {
  const Eigen::Index bends = information.halves[0].cols() - large.num_free();
  Eigen::MatrixXd p = Eigen::MatrixXd::Zero(large.num_free() + bends, model.num_free() + bends);
  p.bottomRightCorner(bends, bends).setIdentity();
  for (std::size_t i = 0; i < large.free().size(); ++i)
    for (std::size_t j = 0; j < model.free().size(); ++j)
      if (std::ranges::count(model.free()[j].lens_parameters,
                             large.free()[i].lens_parameters.front()) > 0)
        p(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = 1;
  BundleInformation result = information;
  for (Eigen::MatrixXd& half : result.halves) half = p.transpose() * half * p;
  for (Eigen::VectorXd& gradient : result.gradients) gradient = p.transpose() * gradient;
  for (Eigen::MatrixXd& pose : result.pose_by_parameters) pose *= p;
  return result;
}

bool is_centre(const FreeParameter& free) { return free.kind() == ParameterKind::principal_point; }

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

std::optional<Observability> simpler_model_test(const Bundle& solved,
                                                const Eigen::MatrixXd& covariance, double sigma) {
  const int more = solved.model->num_free() - 1;
  if (more <= 0) return std::nullopt;
  const double square = sigma * sigma;
  const double most = square * more * std::log(2.0 * num_corners(solved));
  if (solved.views.size() > kFewViews &&
      !fit_plain_lens(spread_views(solved, kFewViews), sigma, most).explains())
    return std::nullopt;
  PlainFit fit = fit_plain_lens(solved, sigma, most);
  if (fit.refused.status != Status::ok) return fit.refused;
  if (!fit.plain ||
      distance_square(*fit.plain, solved, covariance) <
          policy::kCurvedCost * (fit.excess / square + policy::kCurvedCost * policy::kCurvedCost))
    return std::nullopt;
  fit.refused.status = Status::not_observable;
  fit.refused.reason = "not observable from these views: model " +
                       std::string(solved.model->name()) +
                       " fits the noise, so its standard deviations are too small; model " +
                       std::string(fit.plain->model->name()) + " explains the corners as well";
  return fit.refused;
}

bool within_perspective_field(const Bundle& bundle) {
  if (bundle.model->lens_type() == LensType::perspective) return true;
  for (std::size_t v = 0; v < bundle.views.size(); ++v) {
    for (const Correspondence& c : bundle.views[v].correspondences) {
      const Eigen::Vector3d x = bundle.camera_from_target[v] * c.point;
      if (x.z() < policy::kPerspectiveCosine * x.norm()) return false;
    }
  }
  return true;
}

Bundle with_model(const Bundle& bundle, const Model& model) {
  Bundle result = bundle;
  result.model = &model;
  result.free_values = model.free_values(bundle.lens());
  return result;
}

std::optional<BundleInformation> nested_information(const Bundle& solved) {
  return bundle_information(with_model(solved, solved.model->sibling("opencv8")));
}

std::optional<LargerModelStep> step_to_larger_model(const Bundle& solved,
                                                    const BundleInformation& nested,
                                                    const Model& larger, double sigma) {
  LargerModelStep result{with_model(solved, larger), {}, {}, 0};
  BundleInformation information = restricted(nested, solved.model->sibling("opencv8"), larger);
  const ImageSize& size = solved.image_size;
  const double spread_px = policy::kCentreSpread * std::hypot(size.width, size.height);
  const bool is_new = std::ranges::none_of(solved.model->free(), is_centre);
  for (int i = 0; i < larger.num_free(); ++i)
    if (is_new && is_centre(larger.free()[static_cast<std::size_t>(i)]))
      information.halves[0](i, i) += std::pow(sigma / spread_px, 2);
  information.raise_unobservable();
  auto covariance = covariance_of(result.bundle, information, sigma);
  if (!covariance) return std::nullopt;
  result.covariance = std::move(*covariance);
  // The gradient by the bends of a board is zero: the solved bundle has estimated them.
  const Eigen::VectorXd gradient =
      (information.gradients[0] + information.gradients[1]).head(larger.num_free());
  result.step = -result.covariance.parameters * gradient / (sigma * sigma);
  result.chi_square = result.covariance.decrement;
  return result;
}

std::optional<LargerLens> larger_lens(const Bundle& solved, double sigma) {
  const Model& usual = solved.model->sibling("opencv5");
  if (solved.model->lens_type() != LensType::perspective ||
      solved.model->num_free() >= usual.num_free())
    return std::nullopt;
  const auto nested = nested_information(solved);
  const auto step = nested ? step_to_larger_model(solved, *nested, usual, sigma) : std::nullopt;
  if (!step) return std::nullopt;
  // numeric: no division by zero for exact corners
  const double cost = std::max(cost_of(solved), 1e-300);
  return LargerLens{step->chi_square, step->chi_square * sigma * sigma / cost};
}

CalibrationInput spread_views(const CalibrationInput& input, std::size_t count) {
  CalibrationInput few{input.image_size, input.models,   {},
                       input.bent_board, input.whitened, input.model_error_px};
  for (const std::size_t v : spread_indices(input.views.size(), count))
    few.views.push_back(input.views[v]);
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
