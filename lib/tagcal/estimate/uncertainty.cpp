#include "tagcal/estimate/uncertainty.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace tagcal {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

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

std::optional<ViewInformation> information_of(const ViewProblem& view, const Lens& lens,
                                              std::span<const FreeParameter> free,
                                              const Pose& camera_from_target) {
  const auto j = view_jacobians(view, lens, free, camera_from_target);
  if (!j) return std::nullopt;
  const auto inverse = exact_inverse(j->by_pose.transpose() * j->by_pose);
  if (!inverse) return std::nullopt;
  const MatrixXd rest =
      j->by_parameters - j->by_pose * (*inverse * (j->by_pose.transpose() * j->by_parameters));
  return ViewInformation{rest.transpose() * rest, rest.transpose() * j->residuals};
}

std::optional<BundleCovariance> covariance_of(const Bundle& bundle, double sigma) {
  const Lens lens = bundle.lens();
  const Eigen::Index k = bundle.model->num_free();
  MatrixXd schur = MatrixXd::Zero(k, k);
  std::vector<MatrixXd> pose_inverse, pose_by_parameters;  // (A'A)^-1 and (A'A)^-1 A'B
  for (std::size_t i = 0; i < bundle.views.size(); ++i) {
    const auto j =
        view_jacobians(bundle.views[i], lens, bundle.model->free(), bundle.camera_from_target[i]);
    if (!j) return std::nullopt;
    const std::optional<MatrixXd> inverse = exact_inverse(j->by_pose.transpose() * j->by_pose);
    if (!inverse) return std::nullopt;
    const MatrixXd ab = j->by_pose.transpose() * j->by_parameters;
    pose_inverse.push_back(*inverse);
    pose_by_parameters.push_back(*inverse * ab);
    // B'B - B'A (A'A)^-1 A'B as a square, which stays positive where the difference would not.
    const MatrixXd rest = j->by_parameters - j->by_pose * pose_by_parameters.back();
    schur += rest.transpose() * rest;
  }
  BundleCovariance covariance;
  const double square = sigma * sigma;
  if (k > 0) {
    const std::optional<MatrixXd> inverse = exact_inverse(schur);
    if (!inverse) return std::nullopt;
    covariance.parameters = square * *inverse;
  }
  for (std::size_t i = 0; i < pose_inverse.size(); ++i) {
    MatrixXd c = square * pose_inverse[i];
    if (k > 0)
      c += pose_by_parameters[i] * covariance.parameters * pose_by_parameters[i].transpose();
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
  for (std::size_t i = 0; i < bundle.views.size(); ++i)
    for (const Correspondence& c : bundle.views[i].correspondences)
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
