#include "tagcal/estimate/bundle/observability.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"

namespace tagcal::internal {
namespace {

double half_diagonal(const ImageSize& size) { return std::hypot(size.width, size.height) / 2; }

constexpr std::string_view kTiltMore =
    "take views with the board tilted by 20 degrees or more, in several directions";
constexpr std::string_view kSmallerModel =
    "take a smaller model, or more views, tilted in several directions and up to the border of the "
    "image";

// The derivative of log f on the axis by a shape of the lens.
double log_focal_by(const Lens& lens, int parameter) {
  constexpr double kStep = 1e-6;  // numeric: of a central difference
  const auto values = parameters(lens);
  double sum = 0;
  for (const double sign : {1.0, -1.0}) {
    std::vector<double> moved(values.begin(), values.end());
    moved[static_cast<std::size_t>(parameter)] += sign * kStep;
    const auto other = kind_of(lens).lens(moved);
    sum += sign * std::log(focal_lengths_px(other ? *other : lens).x());
  }
  return sum / (2 * kStep);
}

// The largest sd(f) / f of the focal lengths of a lens on its axis.
double relative_focal_sigma(const UncertainCamera& known) {
  const auto values = parameters(known.camera.lens);
  double largest = 0;
  for (const int axis : {0, 1}) {
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(known.model->num_free());
    for (int i = 0; i < known.model->num_free(); ++i) {
      const std::vector<int>& sets =
          known.model->free()[static_cast<std::size_t>(i)].lens_parameters;
      if (std::ranges::count(sets, axis) > 0)
        gradient[i] = 1 / values[static_cast<std::size_t>(axis)];
      else if (known.model->parameter(static_cast<std::size_t>(i)).role == ParameterRole::shape)
        gradient[i] = log_focal_by(known.camera.lens, sets.front());
    }
    const double variance = gradient.dot(known.covariance * gradient);
    largest = std::max(largest, std::sqrt(std::max(0.0, variance)));
  }
  return largest;
}

}  // namespace

Observability observability(const Bundle& bundle, const Model& model,
                            const Eigen::MatrixXd& covariance) {
  Observability result;
  if (degrees_of_freedom(bundle) < policy::kFewestDegreesOfFreedom) {
    result.status = Status::degenerate;
    result.reason = "too few corners for the parameters: " + std::to_string(num_corners(bundle)) +
                    " corners in " + std::to_string(bundle.views.size()) +
                    " views; take more views, or a smaller model";
    return result;
  }
  const UncertainCamera claim{&model, {bundle.lens(), bundle.image_size}, covariance};
  result.focal_share = relative_focal_sigma(claim);
  if (!(result.focal_share <= policy::kFocalRefused)) {
    result.status = Status::focal_not_observable;
    result.reason = "the views do not determine the focal length (its standard deviation is " +
                    percent(result.focal_share) + " of it): " + std::string(kTiltMore);
    return result;
  }
  const Eigen::MatrixXd by_parameters =
      aligned_jacobian(claim, seen_region(bundle).samples(), kInfinitelyFar);
  const double sum = (by_parameters * covariance).cwiseProduct(by_parameters).sum();
  result.projection_px = std::sqrt(
      std::max(0.0, sum) / static_cast<double>(std::max<Eigen::Index>(1, by_parameters.rows())));
  if (result.projection_px < policy::kProjectionRefused * half_diagonal(bundle.image_size))
    return result;
  result.status = Status::not_observable;
  result.reason =
      "the views do not determine the lens (the standard deviation of the projection "
      "at infinity is " +
      std::to_string(std::lround(std::min(result.projection_px, 1e9))) +
      " px): " + std::string(kSmallerModel);
  return result;
}

BundleSummary solve_until_converged(Bundle& bundle, int max_iterations, std::size_t num_threads) {
  constexpr int kMaxRounds = 10;
  constexpr double kStationary = 0.01;  // numeric: corners move by a tenth of their deviation
  const double k = bundle.num_parameters(), freedom = std::max(1, degrees_of_freedom(bundle));
  BundleSummary summary = solve(bundle, max_iterations, num_threads);
  for (int round = 0; round < kMaxRounds && !summary.converged; ++round) {
    BundleSummary more = solve(bundle, max_iterations, num_threads);
    const double decrease = summary.cost + summary.prior - more.cost - more.prior;
    more.num_iterations += summary.num_iterations;
    more.converged |= decrease < kStationary * k * more.cost / freedom;
    summary = more;
  }
  return summary;
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

std::vector<double> distances_m(const Bundle& bundle) {
  std::vector<double> distances;
  for (std::size_t v = 0; v < bundle.views.size(); ++v) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Correspondence& c : bundle.views[v].correspondences) sum += c.point;
    const auto count = static_cast<double>(bundle.views[v].correspondences.size());
    distances.push_back((bundle.camera_from_target[v] * (sum / count).eval()).norm());
  }
  return distances;
}

int degrees_of_freedom(const Bundle& bundle) {
  const int of_view = bundle.is_rolling() ? 12 : 6;  // pose and velocity
  return 2 * num_corners(bundle) - bundle.model->num_free() -
         of_view * static_cast<int>(bundle.views.size());
}

Bundle with_model(const Bundle& bundle, const Model& model) {
  Bundle result = bundle;
  result.model = &model;
  result.free_values = model.free_values(bundle.lens());
  return result;
}

}  // namespace tagcal::internal
