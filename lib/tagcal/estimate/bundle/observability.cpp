#include "tagcal/estimate/bundle/observability.hpp"

#include "tagcal/internal/text.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace tagcal::internal {
namespace {

constexpr double kFocalRefused = 0.10;       // sd(f) / f
constexpr double kProjectionRefused = 0.02;  // of the half-diagonal
constexpr int kFewestDegreesOfFreedom = 11;

double half_diagonal(const ImageSize& size) { return 0.5 * std::hypot(size.width, size.height); }

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

// What the information, scaled to a unit diagonal, leaves wholly open.
class OpenDirections {
 public:
  explicit OpenDirections(const Eigen::MatrixXd& information) {
    const Eigen::VectorXd scale =
        information.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
    spectrum_.compute(scale.asDiagonal() * information * scale.asDiagonal());
  }

  // Below this an eigenvalue is made of rounding, and so is what an inverse makes of it.
  bool any() const { return spectrum_.eigenvalues()[0] < kRounding; }

  // The parameters that take part in them.
  std::vector<std::string> names(const Model& model) const {
    std::vector<std::string> result;
    for (int k = 0; k < model.num_free(); ++k)
      if (takes_part(k)) result.emplace_back(model.free()[static_cast<std::size_t>(k)].name);
    return result;
  }

  // A focal length where one takes part in them, else what the weakest of them is made of.
  std::string weakest(const Model& model) const {
    for (const std::string& name : names(model))
      if (name[0] == 'f') return name;
    Eigen::Index strongest = 0;
    spectrum_.eigenvectors().col(0).cwiseAbs().maxCoeff(&strongest);
    return std::string(model.free()[static_cast<std::size_t>(strongest)].name);
  }

 private:
  static constexpr double kRounding = 1e-11;
  static constexpr double kTakesPart = 0.1;  // of a unit eigenvector

  bool takes_part(Eigen::Index k) const {
    for (Eigen::Index i = 0; i < spectrum_.eigenvalues().size(); ++i) {
      if (i > 0 && spectrum_.eigenvalues()[i] > kRounding) break;
      if (std::abs(spectrum_.eigenvectors()(k, i)) > kTakesPart) return true;
    }
    return false;
  }

  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum_;
};

Eigen::MatrixXd of_parameters(const BundleInformation& information, Eigen::Index k) {
  return (information.halves[0] + information.halves[1]).topLeftCorner(k, k);
}

bool is_known(const std::optional<BundleInformation>& information) {
  return information && information->halves[0].allFinite() && information->halves[1].allFinite();
}

// With so little more on the diagonal that an open direction keeps a million times the deviation
// that its parameters had alone: in a projection that sees it, this is far beyond all bounds.
std::optional<BundleCovariance> covariance_with_open(BundleInformation information, Eigen::Index k,
                                                     double sigma) {
  constexpr double kMore = 1e-12;
  const Eigen::VectorXd diagonal =
      information.halves[0].diagonal() + information.halves[1].diagonal();
  information.halves[0].diagonal() += kMore * diagonal;
  return covariance_of(information, k, sigma);
}

// Where the information has no inverse.
void refuse(Observability& result, const Bundle& bundle,
            const std::optional<BundleInformation>& information) {
  const int k = bundle.model->num_free();
  const std::string open =
      is_known(information) && k > 0
          ? OpenDirections(of_parameters(*information, k)).weakest(*bundle.model)
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

void find_covariance(Observability& result, const Bundle& bundle,
                     const std::optional<BundleInformation>& information, double sigma,
                     bool bend_open) {
  if (!information) return;
  const Eigen::Index k = bundle.model->num_free(), all = k + (bend_open ? 2 : 0);
  if (k > 0 && is_known(information)) {
    const OpenDirections open(of_parameters(*information, k));
    if (open.any()) result.open = open.names(*bundle.model);
  }
  result.covariance = result.open.empty() ? covariance_of(*information, all, sigma)
                                          : covariance_with_open(*information, all, sigma);
  if (!result.covariance) return;
  result.covariance->parameters = result.covariance->parameters.topLeftCorner(k, k).eval();
  // Along what is open the inverse of rounding is not a step.
  if (!result.open.empty()) return;
  const Eigen::VectorXd gradient =
      (information->gradients[0] + information->gradients[1]).head(k) / (sigma * sigma);
  result.decrement = gradient.dot(result.covariance->parameters * gradient);
}

}  // namespace

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
  find_covariance(result, bundle, information, sigma, bend_open);
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
  result.projection_px = projection_sigma_at_infinity_px(bundle, covariance);
  judge_focal_length(result, bundle);
  const bool focal_held = result.status == Status::ok;
  const bool held =
      focal_held && result.projection_px < kProjectionRefused * half_diagonal(bundle.image_size);
  if (!held && !result.open.empty()) {
    refuse(result, bundle, information);
  } else if (focal_held && !held) {
    result.status = Status::not_observable;
    const std::string weakest = weakest_parameters(bundle, covariance);
    result.reason = "not observable from these views: " + weakest + (weakest.empty() ? "" : " ") +
                    "(the projection is uncertain by " +
                    std::to_string(std::lround(std::min(result.projection_px, 1e9))) + " px)";
  }
  if (!held) {
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
    if (free[i].name[0] == 'f')
      largest = std::max(largest, std::sqrt(covariance(k, k)) / bundle.free_values[i]);
  }
  return largest;
}

void judge_focal_length(Observability& seen, const Bundle& bundle) {
  seen.focal_share = relative_focal_sigma(bundle, seen.covariance->parameters);
  if (seen.focal_share <= kFocalRefused) return;
  seen.status = Status::focal_not_observable;
  seen.reason = "the focal length cannot be known from these views (sd " +
                percent(seen.focal_share) +
                "): tilt the board by 20 degrees or more, in several directions";
}

}  // namespace tagcal::internal
