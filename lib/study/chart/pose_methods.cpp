#include "study/chart/pose_methods.hpp"

#include <limits>

#include "study/peers/pose_peers.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/solvers/n_point.hpp"
#include "tagcal/solvers/p4pf.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The part of the answer that both kinds of estimates have.
template <typename Estimate>
PoseAnswer answer_of(const Estimate& estimate) {
  PoseAnswer answer;
  answer.status = estimate.status;
  answer.success = is_answer(estimate.status);
  if (!answer.success) return answer;
  answer.camera_from_target = estimate.camera_from_target();
  for (std::size_t i = 1; i < estimate.hypotheses.size(); ++i)
    answer.alternatives.push_back(
        {estimate.hypotheses[i].camera_from_target, estimate.hypotheses[i].covariance});
  return answer;
}

PreparedPose prepare_estimate_pose(const PoseTask& task) {
  return prepare_task<PoseAnswer>(
      task,
      [](const PoseTask& t) {
        PoseOptions options;
        options.sigma_px = t.sigma_px;
        options.groups = t.groups;
        return estimate_pose(t.correspondences, t.camera, options);
      },
      [](const PoseEstimate& estimate) {
        PoseAnswer answer = answer_of(estimate);
        if (answer.success) answer.covariance = estimate.hypotheses.front().covariance;
        return answer;
      });
}

PreparedPose prepare_estimate_pose_and_focal(const PoseTask& task) {
  return prepare_task<PoseAnswer>(
      task,
      [](const PoseTask& t) {
        PoseAndFocalOptions options;
        options.exact_pinhole = true;
        options.sigma_px = t.sigma_px;
        options.groups = t.groups;
        return estimate_pose_and_focal(t.correspondences, t.camera.image_size, options);
      },
      [](const PoseAndFocalEstimate& estimate) {
        PoseAnswer answer = answer_of(estimate);
        if (!answer.success) return answer;
        answer.focal_px = estimate.focal_px;
        answer.covariance_with_focal = estimate.covariance;
        return answer;
      });
}

// The arrays that the solvers take.
struct SolverInput {
  explicit SolverInput(const PoseTask& task) {
    const auto p = parameters(task.camera.lens);
    for (const Correspondence& c : task.correspondences) {
      points.push_back(c.point);
      plane.push_back(c.point.head<2>());
      from_centre.emplace_back(c.pixel.x() - p[2], c.pixel.y() - p[3]);
      rays.emplace_back(from_centre.back().x() / p[0], from_centre.back().y() / p[1], 1);
    }
  }

  std::vector<Vector3d> points, rays;
  std::vector<Vector2d> plane, from_centre;
};

PoseAnswer found_pose(const Pose& pose, double focal_px = 0) {
  PoseAnswer answer;
  answer.success = true;
  answer.camera_from_target = pose;
  answer.focal_px = focal_px;
  return answer;
}

// Sum of squared residuals in the plane of unit focal length.
double squared_residuals(const Pose& pose, const SolverInput& input) {
  double sum = 0;
  for (std::size_t i = 0; i < input.points.size(); ++i)
    sum += ((pose * input.points[i]).hnormalized() - input.rays[i].head<2>()).squaredNorm();
  return sum;
}

PreparedPose prepare_ippe(const PoseTask& task) {
  return prepare_task<PoseAnswer>(
      SolverInput(task),
      [](const SolverInput& input) {
        std::optional<Pose> better;
        double least = std::numeric_limits<double>::infinity();
        if (const auto h = homography(input.plane, input.rays))
          for (const Pose& pose : ippe(*h))
            if (const double squares = squared_residuals(pose, input); squares < least)
              least = squares, better = pose;
        return better;
      },
      [](const std::optional<Pose>& pose) { return pose ? found_pose(*pose) : PoseAnswer{}; });
}

PreparedPose prepare_pnp(const PoseTask& task) {
  return prepare_task<PoseAnswer>(
      SolverInput(task), [](const SolverInput& input) { return pnp(input.points, input.rays); },
      [](const auto& poses) { return poses.empty() ? PoseAnswer{} : found_pose(poses.front()); });
}

PreparedPose prepare_plane_pose_and_focal(const PoseTask& task) {
  return prepare_task<PoseAnswer>(
      SolverInput(task),
      [](const SolverInput& input) { return plane_pose_and_focal(input.plane, input.from_centre); },
      [](const std::optional<PoseAndFocal>& found) {
        return found ? found_pose(found->camera_from_target, found->focal_px) : PoseAnswer{};
      });
}

// Answers with the solution nearest to the truth: a minimal solver does not choose.
PreparedPose prepare_p4pf(const PoseTask& task) {
  return prepare_task<PoseAnswer>(
      SolverInput(task),
      [](const SolverInput& input) {
        return p4pf(std::span<const Vector3d, 4>(input.points.data(), 4),
                    std::span<const Vector2d, 4>(input.from_centre.data(), 4));
      },
      [truth = task.camera_from_target](const auto& solutions) {
        PoseAnswer best;
        for (const PoseAndFocal& s : solutions)
          if (!best.success || angle_between_rad(s.camera_from_target, truth) <
                                   angle_between_rad(best.camera_from_target, truth))
            best = found_pose(s.camera_from_target, s.focal_px);
        return best;
      });
}

std::vector<PoseMethod> with_opengv(std::vector<PoseMethod> methods) {
  for (PoseMethod& method : opengv_poses()) methods.push_back(std::move(method));
  return methods;
}

std::vector<PoseMethod> focal_methods(PoseJob job) {
  const PoseMethod ours = {"tagcal estimate_pose_and_focal", prepare_estimate_pose_and_focal,
                           "sigma_px given; with covariance, status and refusal"};
  if (job == PoseJob::four_space_focal)
    return {
        ours,
        {"tagcal p4pf", prepare_p4pf, "minimal solver; of its solutions the nearest to the truth"}};
  if (job == PoseJob::space_focal) return {ours, opencv_calibrate_camera()};
  return {
      ours,
      {"tagcal plane_pose_and_focal", prepare_plane_pose_and_focal, "closed form, no refinement"},
      opencv_calibrate_camera()};
}

}  // namespace

std::vector<PoseMethod> pose_methods(PoseJob job) {
  const PoseMethod ours = {
      "tagcal estimate_pose", prepare_estimate_pose,
      "sigma_px given; with covariance, status and the search for wrong corners"};
  const PoseMethod our_pnp = {"tagcal pnp", prepare_pnp, "closed form, no refinement"};
  const PoseMethod our_ippe = {"tagcal homography + ippe", prepare_ippe,
                               "closed form, the pose of smaller residuals"};
  const PoseMethod iterative = opencv_pose("ITERATIVE"), sqpnp = opencv_pose("SQPNP");
  const PoseMethod epnp = opencv_pose("EPNP");
  const PoseMethod p3p = opencv_pose("P3P"), ap3p = opencv_pose("AP3P");
  const PoseMethod ransac = opencv_ransac("solvePnPRansac"), autodiff = ceres_autodiff_pose();
  const PoseMethod usac = opencv_ransac("USAC (MSAC, inner LO)");
  switch (job) {
    case PoseJob::tag:
      return with_opengv({ours, our_ippe, our_pnp, opencv_pose("IPPE_SQUARE"), opencv_pose("IPPE"),
                          iterative, sqpnp, epnp, p3p, ap3p, autodiff, ransac, usac,
                          apriltag_pose()});
    case PoseJob::plane:
      return with_opengv({ours, our_ippe, our_pnp, opencv_pose("IPPE"), iterative, sqpnp, epnp,
                          autodiff, ransac, usac});
    case PoseJob::space:
      return with_opengv({ours, our_pnp, iterative, sqpnp, epnp, autodiff, ransac, usac});
    case PoseJob::four_space:
      return with_opengv({ours, our_pnp, sqpnp, epnp, p3p, ap3p, autodiff, ransac, usac});
    case PoseJob::outliers:
      return {ours,
              ransac,
              opencv_ransac("solvePnPRansac AP3P"),
              opencv_ransac("solvePnPRansac SQPNP"),
              usac,
              opencv_ransac("USAC MAGSAC")};
    default:
      return focal_methods(job);
  }
}

}  // namespace tagcal::study
