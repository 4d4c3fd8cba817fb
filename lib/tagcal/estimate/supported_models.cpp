#include "tagcal/estimate/supported_models.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/calibration_diff.hpp"

namespace tagcal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLeastWeight = 1e-4;  // see the header

double akaike(const Rung& rung) { return rung.misfit + 2 * rung.model().num_free(); }

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

// The free parameters of `to` by those of `from`: each is the mean of the lens parameters that it
// sets. Of lenses of two types only the scales and the principal point are the same parameters.
MatrixXd parameters_from(const Model& from, const Model& to) {
  constexpr int kCommon = 4;  // fx, fy, cx, cy
  const bool same = from.lens_type() == to.lens_type();
  MatrixXd result = MatrixXd::Zero(to.num_free(), from.num_free());
  for (int i = 0; i < to.num_free(); ++i) {
    const auto& wanted = to.free()[static_cast<std::size_t>(i)].lens_parameters;
    for (int j = 0; j < from.num_free(); ++j)
      for (const int k : from.free()[static_cast<std::size_t>(j)].lens_parameters)
        if ((same || k < kCommon) && std::find(wanted.begin(), wanted.end(), k) != wanted.end())
          result(i, j) += 1.0 / static_cast<double>(wanted.size());
  }
  return result;
}

// What a model says of the chosen one's parameters: its covariance of them, and the square of the
// difference.
MatrixXd second_moment(const SupportedModel& other, const Bundle& chosen, const MatrixXd& own) {
  const Model& model = *chosen.model;
  const bool same = other.bundle.model->lens_type() == model.lens_type();
  const Lens lens = chosen.lens(), other_lens = other.bundle.lens();
  const MatrixXd map = parameters_from(*other.bundle.model, model);
  MatrixXd result = map * other.covariance.parameters * map.transpose();
  VectorXd difference = VectorXd::Zero(model.num_free());
  for (int i = 0; i < model.num_free(); ++i) {
    const auto& wanted = model.free()[static_cast<std::size_t>(i)].lens_parameters;
    if (!same && wanted.front() >= 4) {
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

}  // namespace

std::vector<SupportedModel> supported_models(const Ladder& ladder, const Rung& chosen,
                                             const CalibrationFit* perspective,
                                             const CalibrationFit* fisheye) {
  std::vector<const Rung*> rungs;
  for (const Rung& rung : ladder.rungs)
    if (&rung != &chosen && rung.holds() && rung.seen.covariance &&
        !contains(chosen.model(), rung.model()))
      rungs.push_back(&rung);
  double least = akaike(chosen);
  for (const Rung* rung : rungs) least = std::min(least, akaike(*rung));
  const auto evidence = [&](const Rung& rung) { return std::exp(0.5 * (least - akaike(rung))); };
  double sum = evidence(chosen);
  for (const Rung* rung : rungs) sum += evidence(*rung);
  std::vector<SupportedModel> supported;
  for (const Rung* rung : rungs) {
    const double weight = evidence(*rung) / sum;
    if (weight < kLeastWeight) continue;
    const bool is_fisheye = rung->model().lens_type() == LensType::fisheye;
    const CalibrationFit* fit = is_fisheye ? fisheye : perspective;
    supported.push_back({rung->bundle, fit->images, *rung->seen.covariance, weight});
  }
  return supported;
}

void add_model_uncertainty(BundleCovariance& covariance, const Bundle& chosen,
                           std::span<const std::string> images,
                           std::span<const SupportedModel> others) {
  const double own = 1 - total_weight(others);
  const MatrixXd parameters = covariance.parameters;
  covariance.parameters *= own;
  for (Matrix6& pose : covariance.poses) pose *= own;
  for (const SupportedModel& other : others) {
    covariance.parameters += other.weight * second_moment(other, chosen, parameters);
    const bool same_views = std::ranges::equal(other.images, images);
    for (std::size_t v = 0; v < covariance.poses.size(); ++v) {
      if (!same_views) {
        covariance.poses[v] /= std::max(1e-300, 1 - other.weight);
        continue;
      }
      const Vector6d d =
          minus(other.bundle.camera_from_target[v], chosen.camera_from_target[v]);
      covariance.poses[v] += other.weight * (other.covariance.poses[v] + d * d.transpose());
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

}  // namespace tagcal
