#include "tagcal/estimate/bundle/observability.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

double half_diagonal(const ImageSize& size) { return std::hypot(size.width, size.height) / 2; }

// Name of the free parameter, other than the focal length, with the largest standard deviation in
// pixels at the corner of the image. Empty if there is none.
std::string weakest_parameter(const Bundle& bundle, const Eigen::MatrixXd& covariance) {
  const Lens lens = bundle.lens();
  const double f = parameters(lens)[0];
  const double radius = half_diagonal(bundle.image_size) / f;
  std::string weakest;
  double largest = 0;
  for (int i = 0; i < bundle.model->num_free(); ++i) {
    const FreeParameter& free = bundle.model->free()[static_cast<std::size_t>(i)];
    const ParameterKind kind = free.kind();
    if (kind == ParameterKind::focal_length) continue;
    const double px_per_unit = kind == ParameterKind::principal_point
                                   ? 1
                                   : f * std::pow(radius, kind == ParameterKind::radial ? 3 : 2);
    const double in_px = std::sqrt(covariance(i, i)) * px_per_unit;
    if (in_px > largest) weakest = free.name;
    largest = std::max(largest, in_px);
  }
  return weakest;
}

// Combinations of parameters that an information, scaled to a unit diagonal, does not determine at
// all: eigenvectors whose eigenvalue is made of rounding.
class UnobservableDirections {
 public:
  explicit UnobservableDirections(const Eigen::MatrixXd& information) {
    const Eigen::VectorXd scale = information.diagonal()
                                      .cwiseSqrt()
                                      .cwiseMax(1e-300)  // numeric: no division by zero
                                      .cwiseInverse();
    spectrum_.compute(scale.asDiagonal() * information * scale.asDiagonal());
  }

  bool any() const { return spectrum_.eigenvalues()[0] < policy::kUnobservableEigenvalue; }

  // Parameters with a component in one of the directions.
  std::vector<std::string> names(const Model& model) const {
    std::vector<std::string> result;
    for (int k = 0; k < model.num_free(); ++k)
      if (has_component(k)) result.emplace_back(model.free()[static_cast<std::size_t>(k)].name);
    return result;
  }

  // Name of a focal length with a component in one of them, else of the largest component of the
  // direction with the smallest eigenvalue.
  std::string weakest(const Model& model) const {
    for (const std::string& name : names(model))
      if (parameter_kind(name) == ParameterKind::focal_length) return name;
    Eigen::Index strongest = 0;
    spectrum_.eigenvectors().col(0).cwiseAbs().maxCoeff(&strongest);
    return std::string(model.free()[static_cast<std::size_t>(strongest)].name);
  }

 private:
  bool has_component(Eigen::Index k) const {
    for (Eigen::Index i = 0; i < spectrum_.eigenvalues().size(); ++i) {
      if (i > 0 && spectrum_.eigenvalues()[i] > policy::kUnobservableEigenvalue) break;
      // numeric: smaller components are not worth a name
      if (std::abs(spectrum_.eigenvectors()(k, i)) > 0.1) return true;
    }
    return false;
  }

  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum_;
};

Eigen::MatrixXd parameter_block(const BundleInformation& information, Eigen::Index k) {
  return information.sum().topLeftCorner(k, k);
}

bool is_finite(const std::optional<BundleInformation>& information) {
  return information && information->halves[0].allFinite() && information->halves[1].allFinite();
}

// Covariance of an information with unobservable directions, whose diagonal is raised so little
// (policy::kUnobservablePrecision) that a projection that depends on them is refused.
std::optional<BundleCovariance> covariance_with_unobservable(BundleInformation information,
                                                             const Bundle& bundle, double sigma) {
  information.raise_unobservable();
  auto covariance = covariance_of(bundle, information, sigma);
  if (covariance) covariance->decrement = 0;  // unobservable directions have no Gauss-Newton step
  return covariance;
}

constexpr std::string_view kTiltMore =
    "take views with the board tilted by 20 degrees or more, in several directions";
constexpr std::string_view kSmallerModel =
    "take a smaller model, or more views, tilted in several directions and up to the border of the "
    "image";

// Sets status and reason for an information without an inverse.
void refuse(Observability& result, const Bundle& bundle,
            const std::optional<BundleInformation>& information) {
  const int k = bundle.model->num_free();
  const std::string weakest =
      is_finite(information) && k > 0
          ? UnobservableDirections(parameter_block(*information, k)).weakest(*bundle.model)
          : "f";
  if (weakest[0] == 'f') {
    result.status = Status::focal_not_observable;
    result.reason = "the views do not determine the focal length: " + std::string(kTiltMore);
  } else {
    result.status = Status::not_observable;
    result.reason = "the views do not determine " + weakest +
                    " apart from other parameters: " + std::string(kSmallerModel);
  }
}

void find_covariance(Observability& result, const Bundle& bundle,
                     const std::optional<BundleInformation>& information, double sigma) {
  if (!information) return;
  const Eigen::Index k = bundle.model->num_free();
  if (k > 0 && is_finite(information)) {
    const UnobservableDirections unobservable(parameter_block(*information, k));
    if (unobservable.any()) result.open = unobservable.names(*bundle.model);
  }
  result.covariance = result.open.empty()
                          ? covariance_of(bundle, *information, sigma)
                          : covariance_with_unobservable(*information, bundle, sigma);
}

// The observability for the noise that the residuals show.
Observability observability_of(const Bundle& bundle, const BundleSummary& summary) {
  const double square = summary.cost / std::max(1, degrees_of_freedom(bundle));
  return observability(bundle, std::max(policy::kLeastSigmaPx, std::sqrt(square)));
}

}  // namespace

void continue_until_converged(Bundle& bundle, BundleSummary& summary, int max_iterations) {
  constexpr int kMaxRounds = 10;
  const double k = bundle.num_parameters(), freedom = std::max(1, degrees_of_freedom(bundle));
  for (int round = 0; round < kMaxRounds && !summary.converged; ++round) {
    if (observability_of(bundle, summary).status != Status::ok) return;
    const BundleSummary more = solve(bundle, max_iterations);
    const double decrease = summary.cost - more.cost;
    summary.num_iterations += more.num_iterations;
    summary.cost = more.cost;
    summary.converged =
        more.converged || decrease < policy::kStationaryDecrease * k * more.cost / freedom;
  }
}

bool stuck_at_domain_limit(const Bundle& bundle, const BundleSummary& summary) {
  const Observability seen = observability_of(bundle, summary);
  return seen.covariance && seen.covariance->decrement > policy::kLargestDecrement;
}

SeenRegion seen_region(const Bundle& bundle) {
  std::vector<Eigen::Vector2d> pixels;
  for (const ViewProblem& view : bundle.views)
    for (const Correspondence& c : view.correspondences) pixels.push_back(c.pixel);
  return {bundle.image_size, pixels};
}

int num_corners(const Bundle& bundle) {
  int count = 0;
  for (const ViewProblem& view : bundle.views)
    count += static_cast<int>(view.correspondences.size());
  return count;
}

double median_distance_m(const Bundle& bundle) {
  constexpr std::size_t kEnoughCorners = 5000;
  const std::size_t stride = 1 + static_cast<std::size_t>(num_corners(bundle)) / kEnoughCorners;
  std::vector<double> distances;
  std::size_t count = 0;
  for (std::size_t v = 0; v < bundle.views.size(); ++v)
    for (const Correspondence& c : bundle.views[v].correspondences)
      if (count++ % stride == 0)
        distances.push_back((bundle.camera_from_target[v] * c.point).norm());
  return median(std::move(distances));
}

int degrees_of_freedom(const Bundle& bundle) {
  return 2 * num_corners(bundle) - bundle.num_parameters() -
         6 * static_cast<int>(bundle.views.size());
}

Observability observability(const Bundle& bundle, double sigma) {
  return observability(bundle, bundle_information(bundle), sigma);
}

Observability observability(const Bundle& bundle,
                            const std::optional<BundleInformation>& information, double sigma) {
  Observability result;
  find_covariance(result, bundle, information, sigma);
  if (degrees_of_freedom(bundle) < policy::kFewestDegreesOfFreedom) {
    result.status = Status::degenerate;
    result.reason = "too few corners for the parameters: " + std::to_string(num_corners(bundle)) +
                    " corners in " + std::to_string(bundle.views.size()) +
                    " views; take more views, or a smaller model";
    return result;
  }
  if (!result.covariance) {
    refuse(result, bundle, information);
    return result;
  }
  const Eigen::MatrixXd& covariance = result.covariance->parameters;
  result.projection_px = projection_sigma_at_infinity_px(bundle, covariance);
  judge_focal_length(result, bundle);
  const bool is_focal_determined = result.status == Status::ok;
  const bool is_determined =
      is_focal_determined &&
      result.projection_px < policy::kProjectionRefused * half_diagonal(bundle.image_size);
  if (!is_determined && !result.open.empty()) {
    refuse(result, bundle, information);
  } else if (is_focal_determined && !is_determined) {
    result.status = Status::not_observable;
    const std::string weakest = weakest_parameter(bundle, covariance);
    result.reason = "the views do not determine " + (weakest.empty() ? "the lens" : weakest) +
                    " (the standard deviation of the projection at infinity is " +
                    std::to_string(std::lround(std::min(result.projection_px, 1e9))) +
                    " px): " + std::string(kSmallerModel);
  }
  if (!is_determined) {
    if (!result.open.empty()) result.covariance.reset();
    result.open.clear();
  }
  return result;
}

double relative_focal_sigma(const Bundle& bundle, const Eigen::MatrixXd& covariance) {
  double largest = 0;
  const auto& free = bundle.model->free();
  for (std::size_t i = 0; i < free.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (free[i].kind() == ParameterKind::focal_length)
      largest = std::max(largest, std::sqrt(covariance(k, k)) / bundle.free_values[i]);
  }
  return largest;
}

void judge_focal_length(Observability& result, const Bundle& bundle) {
  result.focal_share = relative_focal_sigma(bundle, result.covariance->parameters);
  if (result.focal_share <= policy::kFocalRefused) return;
  result.status = Status::focal_not_observable;
  result.reason = "the views do not determine the focal length (its standard deviation is " +
                  percent(result.focal_share) + " of it): " + std::string(kTiltMore);
}

}  // namespace tagcal::internal
