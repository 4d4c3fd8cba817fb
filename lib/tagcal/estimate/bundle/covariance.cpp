#include "tagcal/estimate/bundle/covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal::internal {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kMostDirections = 1000;

std::optional<MatrixXd> exact_inverse(const MatrixXd& information) {
  const VectorXd diagonal = information.diagonal();
  if (!(diagonal.array() > 0).all() || !information.allFinite()) return std::nullopt;
  const VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
  const MatrixXd unit = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::LDLT<MatrixXd> ldlt(unit);
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().array() > policy::kSingularPivot).all())
    return std::nullopt;
  const MatrixXd inverse = ldlt.solve(MatrixXd::Identity(unit.rows(), unit.cols()));
  return MatrixXd(scale.asDiagonal() * inverse * scale.asDiagonal());
}

std::optional<ViewInformation> information_of(const ViewProblem& view, const Lens& lens,
                                              std::span<const FreeParameter> free,
                                              const Pose& camera_from_target,
                                              const FlatBoard* board) {
  const ViewArrays arrays(view);
  std::vector<Eigen::Vector2d> shapes;
  if (board) shapes = board->shapes(arrays.view().points);
  ParameterSums sums(arrays.view(), free,
                     {shapes, board ? board->normal_in_world() : Vector3d::Zero()});
  MatrixXd gram, rows;
  if (!sums.at(lens, camera_from_target, gram)) return std::nullopt;
  const Eigen::Index n = gram.cols() - 7;
  const Matrix6 by_pose = gram.topLeftCorner<6, 6>().selfadjointView<Eigen::Upper>();
  const std::optional<MatrixXd> inverse = exact_inverse(by_pose);
  if (!inverse) return std::nullopt;
  // Triangular rows [J | r] with the same products. The rows below those of the pose are free of
  // it; S as their square stays positive semidefinite, which a difference would not.
  compressed_rows(gram, rows);
  const auto rest = rows.bottomRows(n + 1).rightCols(n + 1);
  ViewInformation result;
  result.pose_inverse = *inverse;
  result.pose_by_parameters = *inverse * gram.block(0, 6, 6, n);
  result.schur = rest.leftCols(n).transpose() * rest.leftCols(n);
  result.gradient = rest.leftCols(n).transpose() * rest.col(n);
  return result;
}

std::optional<BundleInformation> bundle_information(const Bundle& bundle, const FlatBoard* board) {
  const Lens lens = bundle.lens();
  const Eigen::Index n = bundle.model->num_free() + (board ? 2 : 0);
  BundleInformation result;
  result.halves.fill(MatrixXd::Zero(n, n));
  result.gradients.fill(VectorXd::Zero(n));
  for (std::size_t i = 0; i < bundle.views.size(); ++i) {
    auto view = information_of(bundle.views[i], lens, bundle.model->free(),
                               bundle.camera_from_target[i], board);
    if (!view) return std::nullopt;
    result.halves[i % 2] += view->schur;
    result.gradients[i % 2] += view->gradient;
    result.pose_inverse.push_back(view->pose_inverse);
    result.pose_by_parameters.push_back(std::move(view->pose_by_parameters));
  }
  return result;
}

std::optional<BundleCovariance> covariance_of(const Bundle& bundle, double sigma) {
  const auto information = bundle_information(bundle);
  if (!information) return std::nullopt;
  return covariance_of(*information, bundle.model->num_free(), sigma);
}

std::optional<BundleCovariance> covariance_of(const BundleInformation& information, Eigen::Index k,
                                              double sigma) {
  BundleCovariance covariance;
  const double square = sigma * sigma;
  if (k > 0) {
    const MatrixXd schur = (information.halves[0] + information.halves[1]).topLeftCorner(k, k);
    const std::optional<MatrixXd> inverse = exact_inverse(schur);
    if (!inverse) return std::nullopt;
    covariance.parameters = square * *inverse;
  }
  for (std::size_t i = 0; i < information.pose_inverse.size(); ++i) {
    MatrixXd c = square * information.pose_inverse[i];
    const MatrixXd by_parameters = information.pose_by_parameters[i].leftCols(k);
    if (k > 0) c += by_parameters * covariance.parameters * by_parameters.transpose();
    covariance.poses.emplace_back(c);
  }
  return covariance;
}

double projection_sigma_at_infinity_px(const Bundle& bundle, const MatrixXd& covariance) {
  // One "view" of the directions to the corners, at unit distance.
  const Lens lens = bundle.lens();
  std::vector<Vector3d> directions;
  std::size_t count = 0, all = 0;
  for (const ViewProblem& view : bundle.views) all += view.correspondences.size();
  const std::size_t stride = 1 + all / kMostDirections;
  for (std::size_t i = 0; i < bundle.views.size(); ++i)
    for (const Correspondence& c : bundle.views[i].correspondences)
      if (count++ % stride == 0)
        directions.push_back((bundle.camera_from_target[i] * c.point).normalized());
  // There are no observed pixels: the sums with the residual are not used.
  const std::vector<Eigen::Vector2d> pixels(directions.size(), Eigen::Vector2d::Zero());
  ParameterSums sums({directions, pixels}, bundle.model->free());
  MatrixXd gram;
  if (!sums.at(lens, Pose(), gram)) return std::numeric_limits<double>::infinity();
  const Eigen::Index k = covariance.cols();
  MatrixXd by_turn_and_parameters(3 + k, 3 + k), rows;
  by_turn_and_parameters << gram.topLeftCorner(3, 3), gram.block(0, 6, 3, k), MatrixXd::Zero(k, 3),
      gram.block(6, 6, k, k);
  compressed_rows(by_turn_and_parameters, rows);
  const MatrixXd rest = rows.bottomRightCorner(k, k);
  const double trace = (rest * covariance).cwiseProduct(rest).sum();
  return std::sqrt(std::max(0.0, trace) / static_cast<double>(2 * directions.size()));
}

}  // namespace tagcal::internal
