#include "study/peers/pose_peers.hpp"

#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <array>
#include <map>

#include "study/peers/opencv_views.hpp"
#include "study/peers/quiet_stderr.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kNumOpenCv5 = 9;  // fx fy cx cy k1 k2 p1 p2 k3
using OpenCv5 = std::array<double, kNumOpenCv5>;

// A corner under OpenCV's lens of five coefficients (its documentation, "Detailed Description").
struct Reprojection {
  Vector3d point;
  Vector2d pixel;

  template <typename T>
  bool operator()(const T* lens, const T* rotation, const T* translation, T* residual) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    const Vector3 p = Eigen::Map<const Eigen::Quaternion<T>>(rotation) * point.cast<T>() +
                      Eigen::Map<const Vector3>(translation);
    if (!(p.z() > T(0))) return false;
    const T x = p.x() / p.z(), y = p.y() / p.z();
    const T r2 = x * x + y * y;
    const T radial = T(1) + r2 * (lens[4] + r2 * (lens[5] + r2 * lens[8]));
    const T dx = T(2) * lens[6] * x * y + lens[7] * (r2 + T(2) * x * x);
    const T dy = lens[6] * (r2 + T(2) * y * y) + T(2) * lens[7] * x * y;
    residual[0] = lens[0] * (x * radial + dx) + lens[2] - pixel.x();
    residual[1] = lens[1] * (y * radial + dy) + lens[3] - pixel.y();
    return true;
  }
};

struct FreePose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Vector3d translation = Vector3d::Zero();

  void set(const Pose& pose) { rotation = pose.rotation(), translation = pose.translation(); }
};

void add_corner(ceres::Problem& problem, OpenCv5& lens, FreePose& pose, const Vector3d& point,
                const Vector2d& pixel) {
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Reprojection, 2, kNumOpenCv5, 4, 3>(
                               new Reprojection{point, pixel}),
                           nullptr, lens.data(), pose.rotation.coeffs().data(),
                           pose.translation.data());
}

bool solve(ceres::Problem& problem, ceres::LinearSolverType solver) {
  ceres::Solver::Options options;
  options.linear_solver_type = solver;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  const QuietStderr quiet;  // a failed evaluation is logged although logging is silent
  ceres::Solve(options, &problem, &summary);
  return summary.IsSolutionUsable();
}

struct PoseProblem {
  PoseTask task;
  PreparedPose start;
};

std::optional<FreePose> refined(const PoseProblem& from) {
  from.start.solve();
  const PoseAnswer first = from.start.answer();
  if (!first.success) return std::nullopt;
  FreePose pose;
  pose.set(first.camera_from_target);
  OpenCv5 lens{};
  const auto p = parameters(from.task.camera.lens);
  std::copy_n(p.begin(), 4, lens.begin());
  ceres::Problem problem;
  for (const Correspondence& c : from.task.correspondences)
    add_corner(problem, lens, pose, c.point, c.pixel);
  problem.SetManifold(pose.rotation.coeffs().data(), new ceres::EigenQuaternionManifold);
  problem.SetParameterBlockConstant(lens.data());
  if (!solve(problem, ceres::DENSE_QR)) return std::nullopt;
  return pose;
}

std::optional<OpenCv5> calibrated(const CalibrationTask& task) {
  const MrcalProblem start = mrcal_problem(task.dataset, parameters(task.lens)[0]);
  OpenCv5 lens = {start.focal_px, start.focal_px, 0.5 * (start.width - 1),
                  0.5 * (start.height - 1)};
  const std::map<CornerId, Vector3d> points = points_in_world(task.dataset.boards);
  std::vector<FreePose> poses(task.dataset.views.size());
  ceres::Problem problem;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double* at = &start.poses[6 * i];
    poses[i].rotation = exp_rotation(Vector3d(at[0], at[1], at[2]));
    poses[i].translation = Vector3d(at[3], at[4], at[5]);
    for (const Observation& seen : task.dataset.views[i].observations)
      add_corner(problem, lens, poses[i], points.at(seen.id), seen.pixel);
    problem.SetManifold(poses[i].rotation.coeffs().data(), new ceres::EigenQuaternionManifold);
  }
  if (!solve(problem, ceres::DENSE_SCHUR)) return std::nullopt;
  return lens;
}

}  // namespace

PoseMethod ceres_autodiff_pose() {
  return {"Ceres, autodiff",
          [](const PoseTask& task) {
            return prepare_task<PoseAnswer>(PoseProblem{task, opencv_pose("SQPNP").prepare(task)},
                                            refined, [](const std::optional<FreePose>& pose) {
                                              PoseAnswer answer;
                                              answer.success = pose.has_value();
                                              if (pose)
                                                answer.camera_from_target =
                                                    Pose(pose->rotation, pose->translation);
                                              return answer;
                                            });
          },
          "cv::solvePnP SQPNP, then AutoDiffCostFunction, EigenQuaternionManifold, DENSE_QR, "
          "default tolerances; no covariance"};
}

CalibrationMethod ceres_autodiff_calibration() {
  return {"Ceres, autodiff",
          [](const CalibrationTask& task) {
            return prepare_task<CalibrationAnswer>(
                task, calibrated, [](const std::optional<OpenCv5>& lens) {
                  return lens ? CalibrationAnswer(lens->begin(), lens->end()) : CalibrationAnswer{};
                });
          },
          "poses by cv::solvePnP, the true f given, then AutoDiffCostFunction, "
          "EigenQuaternionManifold, DENSE_SCHUR, default tolerances; no outliers looked for, no "
          "covariance"};
}

}  // namespace tagcal::study
