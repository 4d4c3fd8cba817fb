#include "tagcal/estimate/rig/motion_start.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <numbers>
#include <vector>

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
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
  constexpr int kAngles = 48;         // numeric: the bundle converges from 5 degrees
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

// The translations of camera and board by t_P = R_X (R_Y t_Z + t_Y) + t_X: the shortest ones.
Eigen::Matrix<double, 6, 1> translations(std::span<const MotionPair> views, const Matrix3d& turn) {
  Matrix6d information = Matrix6d::Identity();
  Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
  Matrix3d mixed = Matrix3d::Zero();
  for (const MotionPair& v : views) {
    const Matrix3d board_turn = turn * v.rig_from_world.rotation_matrix();
    const Vector3d rest = v.camera_from_board.translation() - turn * v.rig_from_world.translation();
    mixed += board_turn;
    right.head<3>() += rest;
    right.tail<3>() += board_turn.transpose() * rest;
  }
  const auto n = static_cast<double>(views.size());
  information.topRightCorner<3, 3>() = mixed / n;
  information.bottomLeftCorner<3, 3>() = mixed.transpose() / n;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(information);
  constexpr double kNoise =
      2e-6;  // numeric: squared, below it the translation along the axis is noise
  Eigen::Matrix<double, 6, 1> inverse = eigen.eigenvalues();
  for (double& value : inverse) value = value > kNoise ? 1 / value : 0;
  return eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose() *
         (right / n);
}

MotionStart start_with(std::span<const MotionPair> views, const Matrix3d& turn) {
  const Eigen::Matrix<double, 6, 1> t = translations(views, turn);
  Matrix3d of_board = Matrix3d::Zero();
  for (const MotionPair& v : views)
    of_board += v.rig_from_world.rotation_matrix().transpose() * turn.transpose() *
                v.camera_from_board.rotation_matrix();
  return {{Eigen::Quaterniond(turn).normalized(), t.head<3>()},
          {nearest_rotation(of_board), t.tail<3>()}};
}

double squared_rest(std::span<const MotionPair> views, const MotionStart& start) {
  double sum = 0;
  for (const MotionPair& v : views)
    sum += (start.camera_from_rig * (v.rig_from_world * start.world_from_board.translation()) -
            v.camera_from_board.translation())
               .squaredNorm();
  return sum;
}

}  // namespace

std::vector<MotionStart> motion_starts(std::span<const MotionPair> views) {
  std::vector<MotionStart> starts;
  if (views.size() < 3) return starts;
  for (const Matrix3d& rotation : rotations_of_camera(views))
    starts.push_back(start_with(views, rotation));
  return starts;
}

std::optional<MotionStart> motion_start(std::span<const MotionPair> views) {
  const std::vector<MotionStart> starts = motion_starts(views);
  const auto best = std::ranges::min_element(
      starts, {}, [&](const MotionStart& start) { return squared_rest(views, start); });
  return best == starts.end() ? std::nullopt : std::optional(*best);
}

}  // namespace tagcal::internal
