#include "tagcal/estimate/uncertainty.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace tagcal {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kMostDirections = 1000;

std::optional<ViewJacobians> view_jacobians(const ViewProblem& view, const Lens& lens,
                                            std::span<const FreeParameter> free, const Pose& pose) {
  const Eigen::Index rows = 2 * static_cast<Eigen::Index>(view.correspondences.size());
  ViewJacobians j{RowMajor6(rows, 6), RowMajorX(rows, static_cast<Eigen::Index>(free.size())),
                  VectorXd(rows)};
  Eigen::Map<RowMajor6> by_step(j.by_pose.data(), rows, 6);
  Eigen::Map<RowMajorX> by_parameters(j.by_parameters.data(), rows, j.by_parameters.cols());
  ReprojectionOutput output{Eigen::Map<VectorXd>(j.residuals.data(), rows), &by_step,
                            free.empty() ? nullptr : &by_parameters};
  if (!reprojection(view, lens, free, PoseStep{pose, 1.0}, Vector6d::Zero(), output))
    return std::nullopt;
  return j;
}

namespace {

// Two columns more: by the bends of the board, along its normal.
void append_bend(ViewJacobians& j, const ViewProblem& view, const Pose& pose,
                 const FlatBoard& board) {
  const Eigen::Index k = j.by_parameters.cols();
  j.by_parameters.conservativeResize(Eigen::NoChange, k + 2);
  const Vector3d normal = pose.rotation() * board.normal_in_world();
  const Pose board_from_world = board.world_from_board.inverse();
  for (std::size_t i = 0; i < view.correspondences.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(2 * i);
    j.by_parameters.block<2, 2>(row, k) =
        j.by_pose.block<2, 3>(row, 3) * normal *
        board.shape(board_from_world * view.correspondences[i].point).transpose();
  }
}

}  // namespace

std::optional<MatrixXd> exact_inverse(const MatrixXd& information) {
  const VectorXd diagonal = information.diagonal();
  if (!(diagonal.array() > 0).all() || !information.allFinite()) return std::nullopt;
  const VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
  const MatrixXd unit = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::LDLT<MatrixXd> ldlt(unit);
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().array() > 1e-15).all()) return std::nullopt;
  const MatrixXd inverse = ldlt.solve(MatrixXd::Identity(unit.rows(), unit.cols()));
  return MatrixXd(scale.asDiagonal() * inverse * scale.asDiagonal());
}

std::optional<MatrixXd> information_of(const ViewProblem& view, const Lens& lens,
                                       std::span<const FreeParameter> free,
                                       const Pose& camera_from_target) {
  const auto j = view_jacobians(view, lens, free, camera_from_target);
  if (!j) return std::nullopt;
  const auto inverse = exact_inverse(j->by_pose.transpose() * j->by_pose);
  if (!inverse) return std::nullopt;
  const MatrixXd rest =
      j->by_parameters - j->by_pose * (*inverse * (j->by_pose.transpose() * j->by_parameters));
  return MatrixXd(rest.transpose() * rest);
}

std::optional<BundleInformation> bundle_information(const Bundle& bundle, const FlatBoard* board) {
  const Lens lens = bundle.lens();
  const Eigen::Index k = bundle.model->num_free(), n = k + (board ? 2 : 0);
  BundleInformation result;
  result.halves.fill(MatrixXd::Zero(n, n));
  result.gradients.fill(VectorXd::Zero(n));
  for (std::size_t i = 0; i < bundle.views.size(); ++i) {
    const ViewProblem& view = bundle.views[i];
    const Pose& pose = bundle.camera_from_target[i];
    auto j = view_jacobians(view, lens, bundle.model->free(), pose);
    if (!j) return std::nullopt;
    if (board) append_bend(*j, view, pose, *board);
    const std::optional<MatrixXd> inverse = exact_inverse(j->by_pose.transpose() * j->by_pose);
    if (!inverse) return std::nullopt;
    result.pose_inverse.push_back(*inverse);
    result.pose_by_parameters.emplace_back(*inverse * (j->by_pose.transpose() * j->by_parameters));
    // B'B - B'A (A'A)^-1 A'B as a square, which stays positive where the difference would not.
    j->by_parameters.noalias() -= j->by_pose * result.pose_by_parameters.back();
    result.halves[i % 2].noalias() += j->by_parameters.transpose() * j->by_parameters;
    result.gradients[i % 2].noalias() += j->by_parameters.transpose() * j->residuals;
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

std::optional<Matrix6> pose_covariance(const ViewProblem& view, const Lens& lens,
                                       const Pose& camera_from_target, double sigma) {
  const auto j = view_jacobians(view, lens, {}, camera_from_target);
  if (!j) return std::nullopt;
  const auto inverse = exact_inverse(j->by_pose.transpose() * j->by_pose);
  if (!inverse) return std::nullopt;
  return Matrix6(sigma * sigma * *inverse);
}

double projection_sigma_at_infinity_px(const Bundle& bundle, const MatrixXd& covariance) {
  // One "view" of directions: those in which corners were seen, their distance without meaning.
  const Lens lens = bundle.lens();
  ViewProblem directions;
  std::size_t count = 0, all = 0;
  for (const ViewProblem& view : bundle.views) all += view.correspondences.size();
  const std::size_t stride = 1 + all / kMostDirections;
  for (std::size_t i = 0; i < bundle.views.size(); ++i)
    for (const Correspondence& c : bundle.views[i].correspondences)
      if (count++ % stride == 0)
        directions.correspondences.push_back(
            {(bundle.camera_from_target[i] * c.point).normalized(), c.pixel});
  const auto j = view_jacobians(directions, lens, bundle.model->free(), Pose());
  if (!j) return std::numeric_limits<double>::infinity();
  const MatrixXd by_turn = j->by_pose.leftCols<3>();
  const MatrixXd turn =
      (by_turn.transpose() * by_turn).ldlt().solve(by_turn.transpose() * j->by_parameters);
  const MatrixXd rest = j->by_parameters - by_turn * turn;
  const double trace = (rest * covariance).cwiseProduct(rest).sum();
  return std::sqrt(trace / static_cast<double>(rest.rows()));
}

}  // namespace tagcal
