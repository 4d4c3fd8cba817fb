#include "tagcal/uncertainty/known_rig.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <limits>

#include "tagcal/error.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal {

Eigen::Index KnownRig::first_of_lens(std::size_t camera) const {
  auto at = 6 * std::ssize(cameras);
  for (std::size_t c = 0; c < camera; ++c) at += cameras[c].camera.num_free();
  return at;
}

std::optional<std::size_t> KnownRig::reference() const {
  for (std::size_t c = 0; c < cameras.size(); ++c)
    if (minus(cameras[c].camera_from_rig, Pose()).isZero()) return c;
  return std::nullopt;
}

void KnownRig::set_joint_covariance(const MatrixX& joint) {
  const Eigen::Index places = 6 * std::ssize(cameras), size = first_of_lens(cameras.size());
  const Eigen::Index before = 6 * static_cast<Eigen::Index>(reference().value());
  Eigen::MatrixXd onto = Eigen::MatrixXd::Zero(size, joint.rows());
  onto.topLeftCorner(before, before).setIdentity();
  onto.block(before + 6, before, places - 6 - before, places - 6 - before).setIdentity();
  onto.bottomRightCorner(size - places, size - places).setIdentity();
  covariance = onto * joint * onto.transpose();
}

void KnownRig::check_covariance() const {
  const Eigen::Index size = first_of_lens(cameras.size());
  if (covariance.size() == 0 || (covariance.rows() == size && covariance.cols() == size)) return;
  throw Error(
      fmt::format("rig: the covariance of its places and lenses must be {} x {}, got {} x {}", size,
                  size, covariance.rows(), covariance.cols()));
}

Eigen::Matrix<double, 6, 12> pair_by_places(const Pose& a_from_rig, const Pose& b_from_rig) {
  const Pose b_from_a = b_from_rig * a_from_rig.inverse();
  const Eigen::Matrix3d turn = b_from_a.rotation_matrix();
  const Eigen::Matrix3d arm = cross_matrix(turn * a_from_rig.translation());
  Eigen::Matrix<double, 6, 12> by = Eigen::Matrix<double, 6, 12>::Zero();
  by.block<3, 3>(0, 0) = -turn;
  by.block<3, 3>(3, 0) = -arm * turn;
  by.block<3, 3>(3, 3) = -turn;
  by.block<3, 3>(0, 6).setIdentity();
  by.block<3, 3>(3, 6) = arm;
  by.block<3, 3>(3, 9).setIdentity();
  return by;
}

std::optional<double> step_score(const Eigen::VectorXd& step, const MatrixX& covariance) {
  const Eigen::VectorXd sigmas = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  if (!(sigmas.minCoeff() > 0)) return std::nullopt;
  const Eigen::VectorXd scaled = step.cwiseQuotient(sigmas);
  const Eigen::MatrixXd correlation =
      sigmas.cwiseInverse().asDiagonal() * covariance * sigmas.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(correlation);
  constexpr double kNone = 1e-10;  // numeric: of the correlations, whose mean eigenvalue is 1
  double sum = 0, count = 0;
  for (Eigen::Index i = 0; i < step.size(); ++i) {
    if (!(solver.eigenvalues()[i] > kNone)) continue;
    const double along = solver.eigenvectors().col(i).dot(scaled);
    sum += along * along / solver.eigenvalues()[i];
    ++count;
  }
  if (count == 0) return std::nullopt;
  return internal::variance_ratio_score(sum / count, count,
                                        std::numeric_limits<double>::infinity());
}

KnownRig selected(const KnownRig& rig, std::span<const std::size_t> cameras) {
  KnownRig part;
  std::vector<Eigen::Index> rows, rows_of_lenses;
  for (const std::size_t c : cameras) {
    part.cameras.push_back(rig.cameras[c]);
    for (Eigen::Index i = 0; i < 6; ++i) rows.push_back(6 * static_cast<Eigen::Index>(c) + i);
    for (Eigen::Index i = 0; i < rig.cameras[c].camera.num_free(); ++i)
      rows_of_lenses.push_back(rig.first_of_lens(c) + i);
  }
  rows.insert(rows.end(), rows_of_lenses.begin(), rows_of_lenses.end());
  if (rig.covariance.size() > 0) part.covariance = rig.covariance(rows, rows);
  return part;
}

}  // namespace tagcal
