#include "study/atlas/stability_judge.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tagcal::study {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Inverse of a symmetric matrix, independent of the units of its rows; infinite if the matrix is
// not positive definite.
MatrixXd scaled_inverse(const MatrixXd& matrix) {
  const MatrixXd none =
      MatrixXd::Constant(matrix.rows(), matrix.cols(), std::numeric_limits<double>::infinity());
  if (!matrix.allFinite() || !(matrix.diagonal().minCoeff() > 0)) return none;
  const VectorXd scale = matrix.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd unit = scale.asDiagonal() * matrix * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(unit);
  constexpr double kSingular = 1e-14;
  if (!(eigen.eigenvalues()[0] > kSingular)) return none;
  const MatrixXd inverse = eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() *
                           eigen.eigenvectors().transpose();
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

double mahalanobis_square(const VectorXd& error, const MatrixXd& covariance) {
  const MatrixXd information = scaled_inverse(covariance);
  if (!information.allFinite()) return std::numeric_limits<double>::infinity();
  return error.dot(information * error);
}

double largest_sigma(const MatrixXd& covariance) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(eigen.eigenvalues().maxCoeff());
}

// The covariance of a step (omega, tau, ..) after a move of the target's origin by `from_old`, in
// the camera's axes.
MatrixXd with_origin(MatrixXd covariance, const Vector3d& from_old) {
  MatrixXd change = MatrixXd::Identity(covariance.rows(), covariance.cols());
  change.block<3, 3>(3, 0) = -cross_matrix(from_old);
  return change * covariance * change.transpose();
}

}  // namespace

double five_sigma_square(int dof) {
  const double rare = std::erfc(5 / std::sqrt(2.0));
  // Abramowitz & Stegun, 26.4.8. The term of k is (x/2)^(k/2) e^(-x/2) / Gamma(k/2 + 1).
  const auto exceeds = [dof](double x) {
    double share = dof % 2 ? std::erfc(std::sqrt(x / 2)) : std::exp(-x / 2);
    double term = dof % 2 ? std::sqrt(2 * x / std::numbers::pi) * std::exp(-x / 2) : share;
    for (int k = dof % 2 ? 1 : 2; k < dof; k += 2) {
      if (k > 1) term *= x / k;
      share += term;
    }
    return share;
  };
  double low = 1, high = 1000;
  for (int i = 0; i < 100; ++i)
    (exceeds(0.5 * (low + high)) > rare ? low : high) = 0.5 * (low + high);
  return low;
}

PoseJudge::PoseJudge(PoseQuestion question) : question_(std::move(question)) {
  const PoseTask& task = question_.task;
  truth_ = task;
  truth_.correspondences.clear();
  question_.knowable &= question_.right.size() >= 4;
  if (question_.right.empty()) return;
  for (const std::size_t i : question_.right) centre_ += task.correspondences[i].point;
  centre_ /= static_cast<double>(question_.right.size());
  for (const std::size_t i : question_.right) {
    const Correspondence& c = task.correspondences[i];
    truth_.correspondences.push_back({c.point - centre_, c.pixel});
  }
  const Pose& pose = task.camera_from_target;
  truth_.camera_from_target = Pose(pose.rotation(), pose * centre_);
  if (question_.focal)
    information_ = pose_and_focal_information(truth_);
  else
    information_ = pose_information(truth_);
  question_.knowable &= known_by_bound();
}

bool PoseJudge::known_by_bound() const {
  const MatrixXd covariance = scaled_inverse(information_);
  if (!covariance.allFinite()) return false;
  if (question_.focal) return std::sqrt(covariance(6, 6)) < kKnownShare;
  const double distance = truth_.camera_from_target.translation().norm();
  return largest_sigma(covariance.topLeftCorner<3, 3>()) < kKnownShare &&
         largest_sigma(covariance.block<3, 3>(3, 3)) < kKnownShare * distance;
}

PoseAnswer PoseJudge::about_centre(const PoseAnswer& answer) const {
  PoseAnswer centred = answer;
  const auto moved = [&](const Pose& pose) { return Pose(pose.rotation(), pose * centre_); };
  const auto lever = [&](const Pose& pose) -> Vector3d { return pose.rotation() * centre_; };
  const Pose& pose = answer.camera_from_target;
  centred.camera_from_target = moved(pose);
  if (answer.covariance) centred.covariance = with_origin(*answer.covariance, lever(pose));
  if (answer.covariance_with_focal)
    centred.covariance_with_focal = with_origin(*answer.covariance_with_focal, lever(pose));
  for (auto& [other, covariance] : centred.alternatives) {
    covariance = with_origin(covariance, lever(other));
    other = moved(other);
  }
  return centred;
}

double PoseJudge::bound_square(const PoseAnswer& centred) const {
  const VectorXd error = question_.focal ? VectorXd(pose_and_focal_error(centred, truth_))
                                         : VectorXd(pose_error(centred, truth_));
  return error.dot(information_ * error);
}

double PoseJudge::claimed_square(const PoseAnswer& centred) const {
  if (!question_.focal) return mahalanobis_square(pose_error(centred, truth_), *centred.covariance);
  const Matrix7 ridge = along_the_ridge(centred.camera_from_target, centred.focal_px);
  return mahalanobis_square(pose_and_focal_error(centred, truth_),
                            ridge * *centred.covariance_with_focal * ridge.transpose());
}

bool PoseJudge::in_front(const Pose& pose) const {
  return std::all_of(truth_.correspondences.begin(), truth_.correspondences.end(),
                     [&](const Correspondence& c) { return (pose * c.point).z() > 0; });
}

bool PoseJudge::gross(const PoseAnswer& centred) const {
  const Pose& truth = truth_.camera_from_target;
  if (!(angle_between_rad(centred.camera_from_target, truth) < kGrossRotationRad)) return true;
  if (!question_.focal) return false;
  const double ratio = centred.focal_px / parameters(truth_.camera.lens)[0];
  return !(ratio < kGrossFocalRatio && ratio > 1 / kGrossFocalRatio);
}

bool PoseJudge::right_by_bound(const PoseAnswer& centred) const {
  if (gross(centred) || !in_front(centred.camera_from_target)) return false;
  const double less_strict = std::max(1.0, kLeastPeerSigmaPx / truth_.sigma_px);
  return bound_square(centred) <= five_sigma_square(dof()) * less_strict * less_strict;
}

bool PoseJudge::right_by_claim(const PoseAnswer& centred) const {
  return claimed_square(centred) <= five_sigma_square(dof());
}

bool PoseJudge::an_alternative_is_right(const PoseAnswer& centred) const {
  return std::any_of(
      centred.alternatives.begin(), centred.alternatives.end(), [&](const auto& alternative) {
        PoseAnswer other;
        other.camera_from_target = alternative.camera_from_target;
        if (question_.by_bound) return !question_.focal && right_by_bound(other);
        return mahalanobis_square(pose_error(other, truth_), alternative.covariance) <=
               five_sigma_square(6);
      });
}

StabilityVerdict PoseJudge::judge(const PoseAnswer& answer) const {
  StabilityVerdict verdict;
  const bool finite = answer.camera_from_target.rotation().coeffs().allFinite() &&
                      answer.camera_from_target.translation().allFinite();
  verdict.said = answer.status    ? std::string(status_name(*answer.status))
                 : answer.success ? "answer"
                                  : "no answer";
  if (!answer.success) {
    verdict.outcome =
        question_.knowable ? StabilityOutcome::right_but_refused : StabilityOutcome::wrong_and_said;
    return verdict;
  }
  verdict.outcome = StabilityOutcome::wrong_and_silent;
  if (!finite || question_.right.empty()) return verdict;
  const PoseAnswer centred = about_centre(answer);
  verdict.over_bound = std::sqrt(bound_square(centred) / dof());
  verdict.flipped =
      question_.plane && is_flip(centred.camera_from_target, truth_.camera_from_target);
  const bool claims = answer.covariance || answer.covariance_with_focal;
  if (claims && !question_.by_bound ? right_by_claim(centred) : right_by_bound(centred))
    verdict.outcome = StabilityOutcome::right_and_said;
  else if (an_alternative_is_right(centred))
    verdict.outcome = StabilityOutcome::wrong_and_said;
  return verdict;
}

}  // namespace tagcal::study
