#include "tagcal/estimate/bundle/covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/estimate/bundle/repeated_poses.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// The spread of the samples' gradients in the coordinates W p of the parameters p. The information
// of lens, board and priors is I there (H^-1 = W'W).
struct Spread {
  double overdispersion = 1;  // phi
  MatrixXd covariance;        // of the samples' steps, each raised by its leverage
};

// phi: the mean square of the samples' gradients over that of independent residuals, weighed by
// their effect on the parameters, and shrunk to `independent`. Steps: d_v = (I - S_v)^-1/2 g_v has
// the mean square S_v for independent residuals. The root is its Pade approximation (I - S_v / 4)
// (I - 3 S_v / 4)^-1, which stays bounded where one pose alone determines a parameter.
Spread spread_of_samples(const BundleInformation& information, const MatrixXd& w, double variance,
                         double independent) {
  constexpr double kLeast = 0.25, kMost = 0.75;  // numeric: the approximation's coefficients
  const Index n = w.rows();
  const MatrixXd identity = MatrixXd::Identity(n, n);
  Spread spread{1, MatrixXd::Zero(n, n)};
  double observed = 0, expected = 0, squares = 0;
  for (const ViewInformation& sample : information.samples()) {
    const MatrixXd s = w * sample.schur * w.transpose() / variance;
    const VectorXd g = w * sample.gradient / variance;
    const double part = s.trace() - s.squaredNorm();
    observed += g.squaredNorm();
    expected += part;
    squares += part * part;
    const VectorXd step =
        (identity - kLeast * s) * Eigen::LDLT<MatrixXd>(identity - kMost * s).solve(g);
    spread.covariance += step * step.transpose();
  }
  spread.overdispersion = independent;
  if (!(expected > 0)) return spread;
  // Samples that matter little count less: the effective number of samples.
  const double freedom = std::max(0.0, expected * expected / squares - 1);
  const double prior = policy::kOverdispersionViews;
  spread.overdispersion =
      std::max(1.0, (prior * independent + freedom * observed / expected) / (prior + freedom));
  return spread;
}

// Log evidence of row terms of a standard deviation, against none.
double row_evidence(std::span<const ParameterSums::RowEquations> views, double variance,
                    double row_sigma) {
  double sum = 0;
  for (const ParameterSums::RowEquations& rows : views) {
    const VectorXd gradient = rows.gradient / variance;
    MatrixXd total = rows.information / variance;
    total.diagonal().array() += 1 / (row_sigma * row_sigma);
    sum += gradient.dot(Eigen::LLT<MatrixXd>(total).solve(gradient)) / 2 -
           std::log((row_sigma * row_sigma * total).determinant()) / 2;
  }
  return sum;
}

// W with W'W = H^-1: a covariance that is computed as W'XW stays positive semidefinite, although
// the numerator and denominator of a rational lens make H nearly singular. No value if H is
// singular up to rounding.
std::optional<MatrixXd> inverse_root(const MatrixXd& information) {
  const VectorXd diagonal = information.diagonal();
  if (!(diagonal.array() > 0).all() || !information.allFinite()) return std::nullopt;
  const VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<MatrixXd> ldlt(scale.asDiagonal() * information * scale.asDiagonal());
  constexpr double kRounding = 1e-15;  // numeric: a few times that of a double
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().array() > kRounding).all())
    return std::nullopt;
  const MatrixXd scaled = ldlt.transpositionsP() * MatrixXd(scale.asDiagonal());
  MatrixXd root = ldlt.matrixL().solve(scaled);
  root.array().colwise() /= ldlt.vectorD().array().sqrt();
  return root;
}

}  // namespace

std::optional<MatrixXd> exact_inverse(const MatrixXd& information) {
  const std::optional<MatrixXd> root = inverse_root(information);
  return root ? std::optional(MatrixXd(root->transpose() * *root)) : std::nullopt;
}

std::optional<ViewInformation> eliminate_pose(const MatrixXd& gram) {
  const Index n = gram.cols() - 7;
  const Matrix6 by_pose = gram.topLeftCorner<6, 6>().selfadjointView<Eigen::Upper>();
  const std::optional<MatrixXd> inverse = exact_inverse(by_pose);
  if (!inverse) return std::nullopt;
  // Triangular rows [J | r] with the same products. The rows below those of the pose are free of
  // it; S as their square stays positive semidefinite, which a difference would not.
  MatrixXd rows;
  compressed_rows(gram, 6, rows);
  const auto rest = rows.bottomRows(n + 1).rightCols(n + 1);
  ViewInformation result;
  result.pose_inverse = *inverse;
  result.pose_by_parameters = *inverse * gram.block(0, 6, 6, n);
  result.schur = rest.leftCols(n).transpose() * rest.leftCols(n);
  result.gradient = rest.leftCols(n).transpose() * rest.col(n);
  return result;
}

std::optional<ViewInformation> information_of(const Bundle& bundle, std::size_t view,
                                              const Lens& lens) {
  const auto gram =
      products_of(bundle, view, bundle.model->free(), lens, bundle.camera_from_target[view]);
  return gram ? eliminate_pose(*gram) : std::nullopt;
}

std::optional<ViewInformation> information_of(const ViewProblem& view, const Lens& lens,
                                              const Model& model, const Pose& camera_from_target,
                                              const ViewRowTerms& rows) {
  // The target's origin may be so far away that it hides the lens behind rounding, so that the
  // pose is that of the centre of the points.
  Vector3d centre = Vector3d::Zero();
  for (const Correspondence& c : view.correspondences)
    centre += c.point / static_cast<double>(view.correspondences.size());
  ViewProblem about_centre = view;
  for (Correspondence& c : about_centre.correspondences.own()) c.point -= centre;
  const Pose camera_from_centre(camera_from_target.rotation(), camera_from_target * centre);
  const auto gram = products_of(about_centre, model.free(), lens, camera_from_centre, rows);
  auto result = gram ? eliminate_pose(*gram) : std::nullopt;
  if (!result) return std::nullopt;
  Matrix6 origin_by_centre = Matrix6::Identity();
  origin_by_centre.bottomLeftCorner<3, 3>() = cross_matrix(camera_from_target.rotation() * centre);
  result->pose_by_parameters = origin_by_centre * result->pose_by_parameters;
  result->pose_inverse = origin_by_centre * result->pose_inverse * origin_by_centre.transpose();
  return result;
}

MatrixXd BundleInformation::data() const {
  MatrixXd sum = MatrixXd::Zero(prior.rows(), prior.cols());
  for (const ViewInformation& view : views) sum += view.schur;
  return sum;
}

std::vector<ViewInformation> BundleInformation::samples() const {
  if (sample.empty()) return views;
  const Index n = prior.rows();
  std::vector<ViewInformation> sums(num_samples(),
                                    {MatrixXd::Zero(n, n), VectorXd::Zero(n), {}, {}});
  for (std::size_t v = 0; v < views.size(); ++v) {
    sums[sample[v]].schur += views[v].schur;
    sums[sample[v]].gradient += views[v].gradient;
  }
  return sums;
}

std::size_t BundleInformation::num_samples() const {
  return sample.empty() ? views.size() : num_poses(sample);
}

MatrixXd BundleInformation::total(double sigma) const { return data() / (sigma * sigma) + prior; }

VectorXd BundleInformation::gradient(double sigma) const {
  VectorXd sum = VectorXd::Zero(prior.rows());
  for (const ViewInformation& view : views) sum += view.gradient;
  return sum / (sigma * sigma) + prior_gradient;
}

std::optional<BundleInformation> bundle_information(const Bundle& bundle, std::size_t num_threads) {
  const Lens lens = bundle.lens();
  const std::size_t n = bundle.views.size();
  std::vector<std::optional<ViewInformation>> found(n);
  parallel_for(n, threads_for_short_calls(n, num_threads),
               [&](std::size_t v) { found[v] = information_of(bundle, v, lens); });
  BundleInformation result;
  for (std::optional<ViewInformation>& view : found) {
    if (!view) return std::nullopt;
    result.views.push_back(std::move(*view));
  }
  result.sample = pose_numbers(bundle);
  const PriorRows rows = prior_of(bundle);
  result.prior = rows.by_parameters.transpose() * rows.by_parameters;
  result.prior_gradient = rows.by_parameters.transpose() * rows.residuals;
  return result;
}

std::optional<BundleCovariance> covariance_of(const BundleInformation& information, double sigma,
                                              double prior_sigma, double independent) {
  BundleCovariance covariance;
  const Index n = information.prior.cols();
  if (n == 0) return covariance;
  const std::optional<MatrixXd> w = inverse_root(information.total(sigma));
  if (!w) return std::nullopt;
  covariance.decrement = (*w * information.gradient(prior_sigma)).squaredNorm();
  const Spread spread = spread_of_samples(information, *w, sigma * sigma, independent);
  covariance.overdispersion = spread.overdispersion;
  const auto count = static_cast<double>(information.num_samples());
  const double share = count / (count + policy::kSpreadViews);
  const MatrixXd prior = *w * information.prior * w->transpose();
  const MatrixXd scaled = spread.overdispersion * (MatrixXd::Identity(n, n) - prior);
  covariance.all = w->transpose() * (share * spread.covariance + (1 - share) * scaled + prior) * *w;
  return covariance;
}

std::optional<BundleCovariance> covariance_of(const Bundle& bundle,
                                              const BundleInformation& information, double sigma,
                                              double independent) {
  auto covariance = covariance_of(information, sigma, bundle.sigma, independent);
  if (!covariance) return std::nullopt;
  for (const ViewInformation& view : information.views) {
    MatrixXd c = sigma * sigma * view.pose_inverse;
    if (information.prior.cols() > 0)
      c += view.pose_by_parameters * covariance->all * view.pose_by_parameters.transpose();
    covariance->poses.emplace_back(c);
  }
  const Index k = bundle.model->num_free();
  covariance->parameters = covariance->all.topLeftCorner(k, k);
  return covariance;
}

void replace_covariance(BundleCovariance& covariance, const MatrixXd& all,
                        const BundleInformation& information) {
  const MatrixXd more = all - covariance.all;
  covariance.all = all;
  const Index k = covariance.parameters.cols();
  covariance.parameters = all.topLeftCorner(k, k);
  for (std::size_t v = 0; v < covariance.poses.size(); ++v) {
    const MatrixXd& by = information.views[v].pose_by_parameters;
    covariance.poses[v] += by * more * by.transpose();
  }
}

BoardWarp board_warp(const Bundle& bundle, const BundleCovariance& covariance) {
  const Eigen::Matrix4d of_shape = covariance.all.bottomRightCorner<4, 4>();
  BoardWarp warp;
  const Eigen::Vector4d sigma = of_shape.diagonal().cwiseMax(0).cwiseSqrt();
  warp.bend_mm = 1e3 * bundle.shape.head<2>();
  warp.sigma_mm = 1e3 * sigma.head<2>();
  warp.twist_mm = 1e3 * bundle.shape[2];
  warp.sigma_twist_mm = 1e3 * sigma[2];
  warp.aspect = bundle.shape[3];
  warp.sigma_aspect = sigma[3];
  return warp;
}

double row_sigma_of(const Bundle& solved, double sigma) {
  if (std::ssize(solved.views) < policy::kFewestTellingViews)
    return std::ranges::max(policy::kRowSigmas);
  const Lens lens = solved.lens();
  std::vector<ParameterSums::RowEquations> views;
  for (std::size_t v = 0; v < solved.views.size(); ++v)
    if (auto rows = row_equations(solved, v, lens)) views.push_back(std::move(*rows));
  double best = 0, most = 0;
  for (const double row_sigma : policy::kRowSigmas) {
    const double evidence = row_evidence(views, sigma * sigma, row_sigma);
    if (evidence > most) std::tie(best, most) = std::pair(row_sigma, evidence);
  }
  return best;
}

}  // namespace tagcal::internal
