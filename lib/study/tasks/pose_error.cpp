#include "study/tasks/pose_error.hpp"

#include <Eigen/LU>
#include <cmath>

#include "tagcal/camera/batch.hpp"
#include "tagcal/geometry/pose.hpp"

namespace tagcal::study {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

template <int Columns>
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Columns,
                               Columns == 1 ? Eigen::ColMajor : Eigen::RowMajor>;

double focal_of(const PoseTask& task) { return parameters(task.camera.lens)[0]; }

template <int N>
Eigen::Matrix<double, N, N> information(const PoseTask& task) {
  std::vector<Vector3d> points;
  for (const Correspondence& c : task.correspondences) points.push_back(c.point);
  std::vector<Eigen::Vector2d> pixels(points.size());
  std::vector<std::uint8_t> valid(points.size());
  RowMajor<6> by_pose(2 * points.size(), 6);
  RowMajor<1> by_focal(2 * points.size(), 1);
  project_with_jacobians(
      task.camera.lens, task.camera_from_target, points, Model::named("f").free(),
      {pixels, valid, {by_pose.data(), 12 * points.size()}, {by_focal.data(), 2 * points.size()}});
  Eigen::Matrix<double, Eigen::Dynamic, N> rows(by_pose.rows(), N);
  rows.template leftCols<6>() = by_pose;
  if constexpr (N == 7) rows.col(6) = focal_of(task) * by_focal;  // by log f
  return rows.transpose() * rows / (task.sigma_px * task.sigma_px);
}

}  // namespace

Matrix7 along_the_ridge(const Pose& camera_from_target, double focal_px) {
  const Vector3d& t = camera_from_target.translation();
  const double by_z = focal_px / t.z();
  Matrix7 g = Matrix7::Identity();
  g.block<3, 4>(3, 3) << by_z, 0, -by_z * t.x() / t.z(), by_z * t.x(),  //
      0, by_z, -by_z * t.y() / t.z(), by_z * t.y(),                     //
      0, 0, 1 / t.z(), -1;
  return g;
}

Vector6d pose_error(const PoseAnswer& answer, const PoseTask& task) {
  return minus(answer.camera_from_target, task.camera_from_target);
}

Vector7d pose_and_focal_error(const PoseAnswer& answer, const PoseTask& task) {
  const double truth = focal_of(task);
  const Vector3d& a = answer.camera_from_target.translation();
  const Vector3d& b = task.camera_from_target.translation();
  Vector7d error;
  error.head<6>() = pose_error(answer, task);
  error.segment<2>(3) = answer.focal_px * a.hnormalized() - truth * b.hnormalized();
  error[5] = std::log(a.z() / answer.focal_px) - std::log(b.z() / truth);
  error[6] = std::log(answer.focal_px / truth);
  return error;
}

Matrix6 pose_information(const PoseTask& task) { return information<6>(task); }

Matrix7 pose_and_focal_information(const PoseTask& task) {
  const Matrix7 back = along_the_ridge(task.camera_from_target, focal_of(task)).inverse();
  return back.transpose() * information<7>(task) * back;
}

Pose flipped(const Pose& camera_from_plane) {
  const Matrix3d sight =
      rotation_between(camera_from_plane.translation(), Vector3d::UnitZ()).toRotationMatrix();
  Matrix3d turned = sight * camera_from_plane.rotation_matrix();
  turned(2, 0) *= -1;
  turned(2, 1) *= -1;
  turned.col(2) = turned.col(0).cross(turned.col(1));
  return {Eigen::Quaterniond(Matrix3d(sight.transpose() * turned)),
          camera_from_plane.translation()};
}

bool is_flip(const Pose& pose, const Pose& truth) {
  const Pose other = flipped(truth);
  return angle_between_rad(pose, other) < angle_between_rad(pose, truth);
}

}  // namespace tagcal::study
