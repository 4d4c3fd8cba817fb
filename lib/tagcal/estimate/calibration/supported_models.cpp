#include "tagcal/estimate/calibration/supported_models.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/calibration/simpler_model_test.hpp"
#include "tagcal/estimate/calibration_diff.hpp"
#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

bool contains(const Model& larger, const Model& smaller) {
  if (larger.lens_type() != smaller.lens_type()) return false;
  const auto free_lens_parameters = [](const Model& model) {
    std::vector<int> all;
    for (const FreeParameter& free : model.free())
      all.insert(all.end(), free.lens_parameters.begin(), free.lens_parameters.end());
    std::sort(all.begin(), all.end());
    return all;
  };
  const std::vector<int> a = free_lens_parameters(larger), b = free_lens_parameters(smaller);
  return larger.num_free() >= smaller.num_free() &&
         std::includes(a.begin(), a.end(), b.begin(), b.end());
}

bool is_rational(const Model& model) {
  return std::ranges::any_of(
      model.free(), [](const FreeParameter& free) { return free.lens_parameters.front() >= kK4; });
}

// A lens parameter has the same meaning in two models: focal lengths and the principal point
// always; the others for equal lens types, except radial coefficients beside a denominator.
bool is_common(int parameter, const Model& a, const Model& b) {
  if (parameter <= kCy) return true;
  if (a.lens_type() != b.lens_type()) return false;
  if (parameter == kP1 || parameter == kP2) return true;
  return a.lens_type() == LensType::fisheye || is_rational(a) == is_rational(b);
}

// Matrix from the free parameters of `from` to those of `to`: each is the mean of the lens
// parameters that it sets; zero for parameters without common meaning.
MatrixXd parameters_from(const Model& from, const Model& to) {
  MatrixXd result = MatrixXd::Zero(to.num_free(), from.num_free());
  for (int i = 0; i < to.num_free(); ++i) {
    const auto& target = to.free()[static_cast<std::size_t>(i)].lens_parameters;
    for (int j = 0; j < from.num_free(); ++j)
      for (const int k : from.free()[static_cast<std::size_t>(j)].lens_parameters)
        if (is_common(k, from, to) && std::ranges::find(target, k) != target.end())
          result(i, j) += 1.0 / static_cast<double>(target.size());
  }
  return result;
}

// C + d d' of the chosen model's parameters under another model: its covariance C and the
// difference d of the estimates.
MatrixXd second_moment(const SupportedModel& other, const Bundle& chosen, const MatrixXd& own) {
  const Model& model = *chosen.model;
  const Lens lens = chosen.lens(), other_lens = other.bundle.lens();
  const MatrixXd map = parameters_from(*other.bundle.model, model);
  MatrixXd result = map * other.covariance.parameters * map.transpose();
  VectorXd difference = VectorXd::Zero(model.num_free());
  for (int i = 0; i < model.num_free(); ++i) {
    const auto& target = model.free()[static_cast<std::size_t>(i)].lens_parameters;
    if (!is_common(target.front(), *other.bundle.model, model)) {
      result(i, i) = own(i, i);
      continue;
    }
    for (const int k : target)
      difference[i] += (parameters(other_lens)[static_cast<std::size_t>(k)] -
                        parameters(lens)[static_cast<std::size_t>(k)]) /
                       static_cast<double>(target.size());
  }
  return result + difference * difference.transpose();
}

double total_weight(std::span<const SupportedModel> others) {
  double sum = 0;
  for (const SupportedModel& other : others) sum += other.weight;
  return sum;
}

// A located candidate, and the normal equations of the models that contain it.
struct Base {
  const Candidate* candidate = nullptr;
  std::optional<BundleInformation> information;

  void set(const Candidate* other) {
    if (candidate == other) return;
    candidate = other;
    information = other ? nested_information(other->bundle) : std::nullopt;
  }
};

// The data say where the candidate's minimum is. With unobservable coefficients it is a valley (of
// a rational lens: factors that cancel), and rounding decides at which of its points a solver
// stops.
bool is_located(const Candidate& candidate) {
  return candidate.is_usable() && candidate.observability.open.empty();
}

// A candidate and its chi-square. One that is not located may still be the true model: its estimate
// is to first order about the largest located candidate that it contains (`base`, which is set),
// with the step to its minimum added to the covariance.
std::optional<SupportedModel> supported_model(const ModelLadder& ladder, const Candidate& candidate,
                                              Base& base, double& chi_square) {
  chi_square = candidate.chi_square;
  if (is_located(candidate))
    return SupportedModel{candidate.bundle, candidate.fit->views,
                          *candidate.observability.covariance, 0};
  const Candidate* largest = nullptr;
  for (const Candidate& other : ladder.candidates)
    if (is_located(other) && contains(candidate.model(), other.model())) largest = &other;
  base.set(largest);
  if (!base.information) return std::nullopt;
  auto step =
      step_to_larger_model(largest->bundle, *base.information, candidate.model(), ladder.sigma());
  if (!step) return std::nullopt;
  chi_square = largest->chi_square - step->chi_square;
  if (candidate.is_determined() && !candidate.is_estimated)
    chi_square = std::min(chi_square, candidate.chi_square);
  step->covariance.parameters += step->step * step->step.transpose();
  return SupportedModel{std::move(step->bundle), largest->fit->views, std::move(step->covariance),
                        0};
}

}  // namespace

std::vector<SupportedModel> supported_models(const ModelLadder& ladder, const Candidate& chosen,
                                             double inflation) {
  const auto aic = [&](double chi_square, const Model& model) {
    return chi_square / inflation + 2 * model.num_free();
  };
  const double own = aic(chosen.chi_square, chosen.model());
  std::vector<SupportedModel> supported;
  double least = own;
  Base base;
  for (const Candidate& candidate : ladder.candidates) {
    if (&candidate == &chosen || contains(chosen.model(), candidate.model())) continue;
    double chi_square = 0;
    std::optional<SupportedModel> other = supported_model(ladder, candidate, base, chi_square);
    if (!other) continue;
    other->weight = aic(chi_square, candidate.model());
    least = std::min(least, other->weight);
    supported.push_back(std::move(*other));
  }
  double sum = std::exp((least - own) / 2);
  for (SupportedModel& other : supported)
    sum += other.weight = std::exp((least - other.weight) / 2);
  for (SupportedModel& other : supported) {
    other.weight /= sum;
    other.covariance.parameters *= inflation;
    for (Matrix6& pose : other.covariance.poses) pose *= inflation;
  }
  std::erase_if(supported,
                [](const SupportedModel& m) { return m.weight < policy::kLeastModelWeight; });
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
    // Per coordinate: half of the squared differences.
    variance += other.weight * (its.sigma_px.array().square() +
                                (d->u_px.array().square() + d->v_px.array().square()) / 2);
    region += other.weight * (std::pow(its.region_px, 2) + std::pow(d->rms_px, 2) / 2);
    region_max += other.weight * (std::pow(its.region_max_px, 2) + std::pow(d->max_px, 2) / 2);
  }
  projection.sigma_px = variance.sqrt();
  projection.region_px = std::sqrt(region);
  projection.region_max_px = std::sqrt(region_max);
}

}  // namespace tagcal::internal
