#include "tagcal/estimate/rig/motion_start.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <numbers>
#include <utility>
#include <vector>

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

// The rotations that explain the turns: one, or, if all turns have nearly one axis, those about it.
std::vector<Matrix3d> rotations_of_camera(std::span<const MotionPair> views) {
  Matrix3d sum = Matrix3d::Zero();
  for (std::size_t i = 0; i < views.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const auto turn = [&](const Pose& a, const Pose& b) {
        return log_rotation(a.rotation() * b.rotation().conjugate());
      };
      sum += turn(views[i].camera_from_board, views[k].camera_from_board) *
             turn(views[i].rig_from_world, views[k].rig_from_world).transpose();
    }
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vector3d& size = svd.singularValues();
  constexpr double kRounding = 1e-9;  // numeric: squares of angles
  constexpr double kOneAxis = 0.05;   // numeric: the search below costs little
  constexpr int kAngles = 72;         // numeric: the bundle converges from 5 degrees
  if (!(size[0] > kRounding)) return {};
  Matrix3d flip = Matrix3d::Identity();
  flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  const Matrix3d rotation = svd.matrixU() * flip * svd.matrixV().transpose();
  if (size[1] > kOneAxis * size[0]) return {rotation};
  std::vector<Matrix3d> rotations;
  for (int i = 0; i < kAngles; ++i)
    rotations.push_back(
        rotation *
        exp_rotation(2 * std::numbers::pi * i / kAngles * svd.matrixV().col(0)).toRotationMatrix());
  return rotations;
}

// The translations of camera and board by t_P = R_X (R_Y t_Z + t_Y) + t_X, and what they leave.
struct Translations {
  Eigen::VectorXd values;
  double rest = 0;
};
Translations translations(std::span<const MotionPair> views, const Matrix3d& turn) {
  MatrixXd by_translations(3 * std::ssize(views), 6);
  Eigen::VectorXd right(3 * std::ssize(views));
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto row = 3 * static_cast<Eigen::Index>(i);
    by_translations.block<3, 3>(row, 0).setIdentity();
    by_translations.block<3, 3>(row, 3) = turn * views[i].rig_from_world.rotation_matrix();
    right.segment<3>(row) =
        views[i].camera_from_board.translation() - turn * views[i].rig_from_world.translation();
  }
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
  solver.setThreshold(1e-3);  // numeric: below it the translation along the axis is noise
  solver.compute(by_translations);
  const Eigen::VectorXd t = solver.solve(right);
  return {t, (by_translations * t - right).squaredNorm()};
}

}  // namespace

std::optional<MotionStart> motion_start(std::span<const MotionPair> views) {
  if (views.size() < 3) return std::nullopt;
  std::optional<std::pair<Matrix3d, Translations>> best;
  for (const Matrix3d& rotation : rotations_of_camera(views)) {
    Translations found = translations(views, rotation);
    if (!best || found.rest < best->second.rest) best = {rotation, std::move(found)};
  }
  if (!best) return std::nullopt;
  const auto& [turn, found] = *best;
  Matrix3d of_board = Matrix3d::Zero();
  for (const MotionPair& v : views)
    of_board += v.rig_from_world.rotation_matrix().transpose() * turn.transpose() *
                v.camera_from_board.rotation_matrix();
  return MotionStart{{Eigen::Quaterniond(turn).normalized(), found.values.head<3>()},
                     {nearest_rotation(of_board), found.values.tail<3>()}};
}

}  // namespace tagcal::internal
