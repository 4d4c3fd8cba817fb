#include "tagcal/estimate/calibration/posterior.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/bundle/point_errors.hpp"
#include "tagcal/estimate/bundle/profile_covariance.hpp"
#include "tagcal/estimate/bundle/repeated_poses.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Parameters x = P y + c of a model in which another one is nested; the rows of D restrict x.
struct Restriction {
  MatrixXd p, d;
  VectorXd offset;
};

// The value that a model holds a lens parameter at.
double held_value(const Model& model, int parameter, const ImageSize& size) {
  const Lens plain = plain_lens(model.kind(), 1, image_centre(size));
  const Lens lens = *model.lens(model.free_values(plain), size);
  return parameters(lens)[static_cast<std::size_t>(parameter)];
}

std::optional<Restriction> restriction(const Model& large, const Model& small,
                                       const ImageSize& size, Index num_shapes) {
  if (&large.kind() != &small.kind()) return std::nullopt;
  const Index n = large.num_free(), m = small.num_free();
  Restriction r{MatrixXd::Zero(n + num_shapes, m + num_shapes), MatrixXd::Zero(n, n + num_shapes),
                VectorXd::Zero(n + num_shapes)};
  r.p.bottomRightCorner(num_shapes, num_shapes).setIdentity();
  std::vector<bool> used(static_cast<std::size_t>(m));
  std::vector<Index> first(static_cast<std::size_t>(m), -1);  // parameter that a free one sets
  Index count = 0;
  for (Index i = 0; i < n; ++i) {
    const int parameter = large.free()[static_cast<std::size_t>(i)].lens_parameters.front();
    const auto free = std::ranges::find_if(small.free(), [&](const FreeParameter& f) {
      return std::ranges::count(f.lens_parameters, parameter) > 0;
    });
    if (free == small.free().end()) {
      r.offset[i] = held_value(small, parameter, size);
      r.d(count++, i) = 1;
      continue;
    }
    const auto j = static_cast<std::size_t>(free - small.free().begin());
    r.p(i, static_cast<Index>(j)) = 1;
    used[j] = true;
    if (first[j] >= 0) {
      r.d(count, i) = 1;
      r.d(count++, first[j]) = -1;
    } else {
      first[j] = i;
    }
  }
  if (std::ranges::count(used, false) > 0) return std::nullopt;
  r.d.conservativeResize(count, Eigen::NoChange);
  return r;
}

// log |D P D'| / |D V D'| for the prior covariance P and the posterior's V: the sum of the
// logarithms of the ratios of their variances, each at most policy::kComponentPenalty.
double occam(const MatrixXd& prior, const MatrixXd& covariance, const MatrixXd& d) {
  if (d.rows() == 0) return 0;
  const auto p = exact_inverse(prior);
  if (!p) return 0;
  const Eigen::LLT<MatrixXd> root(d * *p * d.transpose());
  MatrixXd ratio = root.matrixL().solve(d * covariance * d.transpose());
  ratio = root.matrixL().solve(ratio.transpose()).eval();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum(ratio);
  double sum = 0;
  for (const double variance : spectrum.eigenvalues())
    sum += std::clamp(-std::log(std::max(variance, 1e-300)), 0.0,  // numeric: no logarithm of zero
                      policy::kComponentPenalty);
  return sum;
}

}  // namespace

BundleNoise noise_of(const CalibrationFit& fit, const CalibrateOptions& options) {
  const double freedom = degrees_of_freedom(fit.bundle);
  BundleNoise noise;
  noise.from_residuals =
      !(options.sigma_px > 0) && !fit.whitened && freedom >= policy::kEnoughDegreesOfFreedom;
  noise.sigma = options.sigma_px > 0 ? options.sigma_px
                : fit.whitened       ? 1
                : noise.from_residuals
                    ? std::max(kLeastNoisePx, std::sqrt(fit.summary.cost / freedom))
                    : policy::kAssumedSigmaPx;
  return noise;
}

double expected_overdispersion(const Bundle& solved, std::span<const std::size_t> pose_of_view) {
  constexpr std::size_t kEnoughViews = 8;
  const std::size_t stride = 1 + (solved.views.size() - 1) / kEnoughViews;
  const Lens lens = solved.lens();
  NeighbourCorrelation sum;
  ViewProblem buffer;
  for (std::size_t v = 0; v < solved.views.size(); v += stride) {
    const ViewProblem& view = solved.corrected(v, buffer);
    std::vector<Eigen::Vector2d> pixels;
    for (const Correspondence& c : view.correspondences) pixels.push_back(c.pixel);
    sum.add(pixels, residuals_px(view.correspondences, lens, solved.camera_from_target[v]));
  }
  return (policy::kLeastOverdispersion +
          policy::kOverdispersionByCorrelation * std::max(0.0, sum.correlation())) *
         design_effect(solved, pose_of_view);
}

VectorXd Posterior::values() const {
  const Index k = model().num_free(), shapes = fit.bundle.num_shapes();
  VectorXd x(k + shapes);
  x.head(k) = Eigen::Map<const VectorXd>(fit.bundle.free_values.data(), k);
  if (shapes > 0) x.tail(shapes) = fit.bundle.shape;
  return x;
}

std::optional<Posterior> posterior_of(CalibrationFit fit, const CalibrateOptions& options) {
  Posterior posterior;
  posterior.noise = noise_of(fit, options);
  auto information = bundle_information(fit.bundle, options.num_threads);
  if (!information) return std::nullopt;
  auto covariance = covariance_of(fit.bundle, *information, posterior.noise.sigma,
                                  expected_overdispersion(fit.bundle, information->sample));
  if (!covariance) return std::nullopt;
  if (const auto of_points =
          covariance_of_point_errors(fit.bundle, *information, posterior.noise.sigma))
    replace_covariance(*covariance, covariance->all + *of_points, *information);
  posterior.information = std::move(*information);
  posterior.covariance = std::move(*covariance);
  posterior.fit = std::move(fit);
  return posterior;
}

std::optional<Component> nested_in(const Posterior& posterior, const Model& model) {
  const Bundle& bundle = posterior.fit.bundle;
  if (&model == &posterior.model())
    return Component{&model, posterior.values(), posterior.covariance.all};
  const auto r = restriction(posterior.model(), model, bundle.image_size, bundle.num_shapes());
  if (!r) return std::nullopt;
  const VectorXd x = posterior.values();
  const MatrixXd h = posterior.information.total(posterior.noise.sigma);
  const MatrixXd& v = posterior.covariance.all;
  const auto inverse = exact_inverse(r->p.transpose() * h * r->p);
  if (!inverse) return std::nullopt;
  const MatrixXd onto = r->p * *inverse * r->p.transpose() * h;
  Component component;
  component.model = &model;
  component.values = r->offset + onto * (x - r->offset);
  component.covariance = onto * v * onto.transpose();
  const VectorXd excess = x - component.values;
  component.chi_square = excess.dot(h * excess) / posterior.covariance.overdispersion;
  component.occam = occam(posterior.information.prior, v, r->d);
  return component;
}

namespace {

// Two lenses at the nodes of a grid that both see, weighted by the first one's standard deviation.
struct WeightedDifference {
  MatrixXd by_mine, by_its;  // Jacobians by the parameters of the lenses
  VectorXd difference;
};

std::optional<WeightedDifference> weighted_difference(const UncertainCamera& mine,
                                                      const UncertainCamera& its,
                                                      std::span<const Eigen::Vector2d> samples) {
  const auto d = lens_difference(mine.camera, its.camera, samples, kInfinitelyFar);
  if (!d) return std::nullopt;
  const ProjectionUncertainty claimed =
      projection_uncertainty(mine, d->grid, samples, kInfinitelyFar);
  std::vector<Eigen::Vector2d> nodes;
  std::vector<double> differences, weights;
  const std::vector<Eigen::Vector2d> pixels = d->grid.pixels();
  for (Index i = 0; i < d->u_px.size(); ++i) {
    const Index row = i / d->grid.columns, column = i % d->grid.columns;
    if (!std::isfinite(d->u_px(row, column)) || !(claimed.sigma_px(row, column) > 0)) continue;
    nodes.push_back(pixels[static_cast<std::size_t>(i)]);
    differences.insert(differences.end(), {d->u_px(row, column), d->v_px(row, column)});
    weights.insert(weights.end(), 2, 1 / claimed.sigma_px(row, column));
  }
  const MatrixXd by_mine = aligned_jacobian(mine, nodes, kInfinitelyFar);
  const MatrixXd by_its = aligned_jacobian(its, nodes, kInfinitelyFar);
  const Index n = by_mine.rows();
  if (n != by_its.rows() || n != std::ssize(differences) || n < 2 * by_mine.cols())
    return std::nullopt;
  const auto weight = Eigen::Map<const VectorXd>(weights.data(), n).asDiagonal();
  return WeightedDifference{weight * by_mine, weight * by_its,
                            weight * Eigen::Map<const VectorXd>(differences.data(), n)};
}

}  // namespace

std::optional<Component> as_seen_by(const Posterior& other, const Posterior& to) {
  const ImageSize& size = to.fit.bundle.image_size;
  const UncertainCamera mine{&to.model(), {to.fit.bundle.lens(), size}, to.covariance.parameters};
  const UncertainCamera its{&other.model(), {other.fit.bundle.lens(), size}, {}};
  const auto found = weighted_difference(mine, its, seen_region(to.fit.bundle).samples());
  if (!found) return std::nullopt;
  const auto& [by_mine, by_its, difference] = *found;
  const Index k = by_mine.cols(), other_k = by_its.cols(), shapes = to.fit.bundle.num_shapes();
  const auto inverse =
      exact_inverse(by_mine.transpose() * by_mine + to.information.prior.topLeftCorner(k, k));
  if (!inverse) return std::nullopt;
  MatrixXd map = MatrixXd::Zero(k + shapes, other_k + shapes);
  map.topLeftCorner(k, other_k) = *inverse * by_mine.transpose() * by_its;
  map.bottomRightCorner(shapes, shapes).setIdentity();
  Component component;
  component.model = &other.model();
  component.values = to.values();
  component.values.head(k) += *inverse * by_mine.transpose() * difference;
  component.values.tail(shapes) = other.values().tail(shapes);
  component.covariance = map * other.covariance.all * map.transpose();
  return component;
}

MatrixXd curvature_of(const CalibrationFit& answer, const MatrixXd& covariance,
                      const Posterior& posterior) {
  const Bundle& bundle = answer.bundle;
  const Index n = posterior.values().size();
  const auto r =
      restriction(posterior.model(), *bundle.model, bundle.image_size, bundle.num_shapes());
  const auto information = r ? bundle_information(bundle) : std::nullopt;
  if (!information) return MatrixXd::Zero(n, n);
  // The columns of P are orthogonal.
  const MatrixXd inverse =
      (r->p.transpose() * r->p).diagonal().cwiseInverse().asDiagonal() * r->p.transpose();
  const MatrixXd own = inverse * covariance * inverse.transpose();
  const MatrixXd more = profile_covariance(bundle, *information, own, posterior.noise.sigma) - own;
  return r->p * more * r->p.transpose();
}

double occam(const Posterior& posterior) {
  const Index n = posterior.values().size();
  return occam(posterior.information.prior, posterior.covariance.all, MatrixXd::Identity(n, n));
}

MatrixXd mixture_about(const VectorXd& answer, std::span<const Component> components) {
  MatrixXd sum = MatrixXd::Zero(answer.size(), answer.size());
  for (const Component& component : components) {
    const VectorXd d = component.values - answer;
    sum += component.weight * (component.covariance + d * d.transpose());
  }
  return (sum + sum.transpose()) / 2;
}

}  // namespace tagcal::internal
