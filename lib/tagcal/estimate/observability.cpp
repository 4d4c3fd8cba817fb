#include "tagcal/estimate/observability.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace tagcal {
namespace {

constexpr double kFocalRefused = 0.10;       // sd(f) / f
constexpr double kProjectionRefused = 0.02;  // of the half-diagonal
constexpr int kFewestDegreesOfFreedom = 11;

double half_diagonal(const ImageSize& size) { return 0.5 * std::hypot(size.width, size.height); }

double relative_focal_sigma(const Bundle& bundle, const Eigen::MatrixXd& covariance) {
  double largest = 0;
  const auto& free = bundle.model->free();
  for (std::size_t i = 0; i < free.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (free[i].name[0] == 'f')
      largest = std::max(largest, std::sqrt(covariance(k, k)) / bundle.free_values[i]);
  }
  return largest;
}

// The free parameters, the focal length aside, that are least known in pixels at the image corner.
std::string weakest_parameters(const Bundle& bundle, const Eigen::MatrixXd& covariance) {
  const double f = parameters(bundle.lens())[0];
  const double radius = half_diagonal(bundle.image_size) / f;
  std::string names;
  double largest = 0;
  for (int i = 0; i < bundle.model->num_free(); ++i) {
    const std::string_view name = bundle.model->free()[static_cast<std::size_t>(i)].name;
    if (name[0] == 'f') continue;
    const double in_px = std::sqrt(covariance(i, i)) *
                         (name[0] == 'c' ? 1 : f * std::pow(radius, name[0] == 'k' ? 3 : 2));
    if (in_px > largest) names = name;
    largest = std::max(largest, in_px);
  }
  return names;
}

// A parameter of what the information leaves wholly open: a focal length where that takes part.
std::string open_parameter(const Bundle& bundle, const Eigen::MatrixXd& information) {
  constexpr double kOpen = 1e-12;     // of an eigenvalue, where the diagonal is 1
  constexpr double kTakesPart = 0.1;  // of a unit eigenvector
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(scale.asDiagonal() * information *
                                                                scale.asDiagonal());
  const auto& free = bundle.model->free();
  std::string name;
  for (Eigen::Index i = 0; i < information.rows(); ++i) {
    if (i > 0 && spectrum.eigenvalues()[i] > kOpen) break;
    const Eigen::VectorXd direction = spectrum.eigenvectors().col(i).cwiseAbs();
    for (std::size_t k = 0; k < free.size(); ++k)
      if (free[k].name[0] == 'f' && direction[static_cast<Eigen::Index>(k)] > kTakesPart)
        return std::string(free[k].name);
    Eigen::Index strongest = 0;
    direction.maxCoeff(&strongest);
    if (i == 0) name = free[static_cast<std::size_t>(strongest)].name;
  }
  return name;
}

// Where the information has no inverse.
void refuse(Observability& result, const Bundle& bundle,
            const std::optional<BundleInformation>& information) {
  const Eigen::Index k = bundle.model->num_free();
  const bool known =
      information && information->halves[0].allFinite() && information->halves[1].allFinite();
  const std::string open =
      known ? open_parameter(bundle,
                             (information->halves[0] + information->halves[1]).topLeftCorner(k, k))
            : "f";
  if (open[0] == 'f') {
    result.status = Status::focal_not_observable;
    result.reason =
        "the focal length cannot be known from these views: tilt the board by 20 degrees or more";
  } else {
    result.status = Status::not_observable;
    result.reason = "not observable from these views: " + open + " trades with other parameters";
  }
}

}  // namespace

std::string percent(double share) {
  if (!(share <= 10)) return "more than 1000 %";
  return std::to_string(std::lround(100 * share)) + " %";
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
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

int degrees_of_freedom(const Bundle& bundle) {
  return 2 * num_corners(bundle) - bundle.model->num_free() -
         6 * static_cast<int>(bundle.views.size());
}

Observability observability(const Bundle& bundle, double sigma) {
  return observability(bundle, bundle_information(bundle), sigma);
}

Observability observability(const Bundle& bundle,
                            const std::optional<BundleInformation>& information, double sigma,
                            bool bend_open) {
  Observability result;
  const Eigen::Index k = bundle.model->num_free();
  if (information) result.covariance = covariance_of(*information, k + (bend_open ? 2 : 0), sigma);
  if (result.covariance)
    result.covariance->parameters = result.covariance->parameters.topLeftCorner(k, k).eval();
  if (degrees_of_freedom(bundle) < kFewestDegreesOfFreedom) {
    result.status = Status::degenerate;
    result.reason = "too few corners for the parameters: " + std::to_string(num_corners(bundle)) +
                    " corners in " + std::to_string(bundle.views.size()) + " views";
    return result;
  }
  if (!result.covariance) {
    refuse(result, bundle, information);
    return result;
  }
  const Eigen::MatrixXd& covariance = result.covariance->parameters;
  result.focal_share = relative_focal_sigma(bundle, covariance);
  result.projection_px = projection_sigma_at_infinity_px(bundle, covariance);
  if (!(result.focal_share <= kFocalRefused)) {
    result.status = Status::focal_not_observable;
    result.reason = "the focal length cannot be known from these views (sd " +
                    percent(result.focal_share) +
                    "): tilt the board by 20 degrees or more, in several directions";
  } else if (!(result.projection_px < kProjectionRefused * half_diagonal(bundle.image_size))) {
    result.status = Status::not_observable;
    result.reason = "not observable from these views: " + weakest_parameters(bundle, covariance) +
                    " (the projection is uncertain by " +
                    std::to_string(std::lround(std::min(result.projection_px, 1e9))) + " px)";
  }
  return result;
}

}  // namespace tagcal
