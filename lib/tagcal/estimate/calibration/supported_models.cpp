#include "tagcal/estimate/calibration/supported_models.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/calibration/simpler_model_test.hpp"
#include "tagcal/estimate/calibration_diff.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLeastWeight = 1e-4;  // see the header

bool contains(const Model& larger, const Model& smaller) {
  if (larger.lens_type() != smaller.lens_type()) return false;
  const auto sets = [](const Model& model) {
    std::vector<int> all;
    for (const FreeParameter& free : model.free())
      all.insert(all.end(), free.lens_parameters.begin(), free.lens_parameters.end());
    std::sort(all.begin(), all.end());
    return all;
  };
  const std::vector<int> a = sets(larger), b = sets(smaller);
  return larger.num_free() >= smaller.num_free() &&
         std::includes(a.begin(), a.end(), b.begin(), b.end());
}

bool is_rational(const Model& model) {
  return std::ranges::any_of(
      model.free(), [](const FreeParameter& free) { return free.lens_parameters.front() >= kK4; });
}

// Whether a lens parameter means the same in two models: scales and the principal point always do,
// the others of one lens type, but for radial coefficients beside a denominator.
bool is_common(int parameter, const Model& a, const Model& b) {
  if (parameter <= kCy) return true;
  if (a.lens_type() != b.lens_type()) return false;
  if (parameter == kP1 || parameter == kP2) return true;
  return a.lens_type() == LensType::fisheye || is_rational(a) == is_rational(b);
}

// The free parameters of `to` by those of `from`: each is the mean of the lens parameters that it
// sets. Zero for what they do not have in common.
MatrixXd parameters_from(const Model& from, const Model& to) {
  MatrixXd result = MatrixXd::Zero(to.num_free(), from.num_free());
  for (int i = 0; i < to.num_free(); ++i) {
    const auto& wanted = to.free()[static_cast<std::size_t>(i)].lens_parameters;
    for (int j = 0; j < from.num_free(); ++j)
      for (const int k : from.free()[static_cast<std::size_t>(j)].lens_parameters)
        if (is_common(k, from, to) && std::ranges::find(wanted, k) != wanted.end())
          result(i, j) += 1.0 / static_cast<double>(wanted.size());
  }
  return result;
}

// What a model says of the chosen one's parameters: its covariance of them, and the square of the
// difference.
MatrixXd second_moment(const SupportedModel& other, const Bundle& chosen, const MatrixXd& own) {
  const Model& model = *chosen.model;
  const Lens lens = chosen.lens(), other_lens = other.bundle.lens();
  const MatrixXd map = parameters_from(*other.bundle.model, model);
  MatrixXd result = map * other.covariance.parameters * map.transpose();
  VectorXd difference = VectorXd::Zero(model.num_free());
  for (int i = 0; i < model.num_free(); ++i) {
    const auto& wanted = model.free()[static_cast<std::size_t>(i)].lens_parameters;
    if (!is_common(wanted.front(), *other.bundle.model, model)) {
      result(i, i) = own(i, i);
      continue;
    }
    for (const int k : wanted)
      difference[i] += (parameters(other_lens)[static_cast<std::size_t>(k)] -
                        parameters(lens)[static_cast<std::size_t>(k)]) /
                       static_cast<double>(wanted.size());
  }
  return result + difference * difference.transpose();
}

double total_weight(std::span<const SupportedModel> others) {
  double sum = 0;
  for (const SupportedModel& other : others) sum += other.weight;
  return sum;
}

// The views say little of the principal point where they do not determine it, cameras more.
void add_prior_of_centre(BundleInformation& information, const Bundle& bundle, double sigma) {
  const double spread_px =
      kCentreSpread * std::hypot(bundle.image_size.width, bundle.image_size.height);
  const auto& free = bundle.model->free();
  for (std::size_t i = 0; i < free.size(); ++i) {
    const int k = free[i].lens_parameters.front();
    const auto at = static_cast<Index>(i);
    if (k == kCx || k == kCy) information.halves[0](at, at) += std::pow(sigma / spread_px, 2);
  }
}

// A model that cannot be taken (the views do not determine it, the solver stopped at a fold, or
// there is a pole in the image) is still one that may have made the data: to first order about the
// largest model inside it that can be taken. The step to its minimum counts as the difference.
std::optional<SupportedModel> linearised(const Ladder& ladder, const Rung& rung, double& misfit) {
  const Rung* base = nullptr;
  for (const Rung& other : ladder.rungs)
    if (other.holds() && contains(rung.model(), other.model())) base = &other;
  if (!base) return std::nullopt;
  const double sigma = ladder.whitened ? 1 : std::sqrt(ladder.noise_square);
  SupportedModel result{with_model(base->bundle, rung.model()), {}, {}, 0};
  auto information = bundle_information(result.bundle);
  if (!information) return std::nullopt;
  if (rung.seen.status != Status::ok) add_prior_of_centre(*information, result.bundle, sigma);
  const auto covariance = covariance_of(*information, rung.model().num_free(), sigma);
  if (!covariance) return std::nullopt;
  result.covariance = *covariance;
  const VectorXd gradient =
      (information->gradients[0] + information->gradients[1]) / (sigma * sigma);
  const VectorXd step = result.covariance.parameters * gradient;
  misfit = base->misfit - gradient.dot(step);
  if (rung.seen.status == Status::ok) misfit = std::min(misfit, rung.misfit);
  result.covariance.parameters += step * step.transpose();
  return result;
}

std::optional<SupportedModel> as_supported(const Ladder& ladder, const Rung& rung, double& misfit) {
  misfit = rung.misfit;
  if (rung.holds() && rung.seen.covariance)
    return SupportedModel{rung.bundle, {}, *rung.seen.covariance, 0};
  return linearised(ladder, rung, misfit);
}

}  // namespace

std::vector<SupportedModel> supported_models(const Ladder& ladder, const Rung& chosen,
                                             double inflation) {
  const auto akaike = [&](double misfit, const Model& model) {
    return misfit / inflation + 2 * model.num_free();
  };
  const double own = akaike(chosen.misfit, chosen.model());
  std::vector<SupportedModel> supported;
  double least = own;
  for (const Rung& rung : ladder.rungs) {
    if (&rung == &chosen || contains(chosen.model(), rung.model())) continue;
    double misfit = 0;
    std::optional<SupportedModel> other = as_supported(ladder, rung, misfit);
    if (!other) continue;
    other->views = rung.fit->views;
    other->weight = akaike(misfit, rung.model());
    least = std::min(least, other->weight);
    supported.push_back(std::move(*other));
  }
  double sum = std::exp(0.5 * (least - own));
  for (SupportedModel& other : supported)
    sum += other.weight = std::exp(0.5 * (least - other.weight));
  for (SupportedModel& other : supported) {
    other.weight /= sum;
    other.covariance.parameters *= inflation;
    for (Matrix6& pose : other.covariance.poses) pose *= inflation;
  }
  std::erase_if(supported, [](const SupportedModel& m) { return m.weight < kLeastWeight; });
  return supported;
}

void add_model_uncertainty(BundleCovariance& covariance, const Bundle& chosen,
                           std::span<const std::size_t> views,
                           std::span<const SupportedModel> others) {
  const MatrixXd own = covariance.parameters;
  const std::vector<Matrix6> poses = covariance.poses;
  covariance.parameters *= 1 - total_weight(others);
  for (const SupportedModel& other : others)
    covariance.parameters += other.weight * second_moment(other, chosen, own);
  for (const SupportedModel& other : others) {
    if (!std::ranges::equal(other.views, views)) continue;
    for (std::size_t v = 0; v < covariance.poses.size(); ++v) {
      const Vector6d d = minus(other.bundle.camera_from_target[v], chosen.camera_from_target[v]);
      const Matrix6 moment = other.covariance.poses[v] + d * d.transpose();
      covariance.poses[v] += other.weight * (moment - poses[v]);
    }
  }
}

void add_model_uncertainty(ProjectionUncertainty& projection, const Camera& chosen,
                           std::span<const SupportedModel> others,
                           std::span<const Eigen::Vector2d> samples) {
  const double own = 1 - total_weight(others);
  Eigen::ArrayXXd variance = own * projection.sigma_px.array().square();
  double region = own * std::pow(projection.region_px, 2);
  double region_max = own * std::pow(projection.region_max_px, 2);
  for (const SupportedModel& other : others) {
    const Lens lens = other.bundle.lens();
    const ProjectionUncertainty its =
        projection_uncertainty({other.bundle.model, lens, other.covariance.parameters},
                               projection.grid, samples, projection.distance_m);
    const auto d =
        lens_difference(chosen, {lens, chosen.image_size}, samples, projection.distance_m);
    if (!d) {
      projection.region_px = projection.region_max_px = kInfinitelyFar;
      projection.sigma_px.setConstant(std::numeric_limits<double>::quiet_NaN());
      return;
    }
    variance += other.weight * (its.sigma_px.array().square() +
                                0.5 * (d->u_px.array().square() + d->v_px.array().square()));
    region += other.weight * (std::pow(its.region_px, 2) + 0.5 * std::pow(d->rms_px, 2));
    region_max += other.weight * (std::pow(its.region_max_px, 2) + 0.5 * std::pow(d->max_px, 2));
  }
  projection.sigma_px = variance.sqrt();
  projection.region_px = std::sqrt(region);
  projection.region_max_px = std::sqrt(region_max);
}

}  // namespace tagcal::internal
