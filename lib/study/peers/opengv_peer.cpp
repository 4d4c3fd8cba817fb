#include "study/peers/pose_peers.hpp"

#ifdef TAGCAL_HAS_OPENGV

#include <limits>
#include <opengv/absolute_pose/CentralAbsoluteAdapter.hpp>
#include <opengv/absolute_pose/methods.hpp>

namespace tagcal::study {
namespace {

// OpenGV takes rays of unit length, and gives target_from_camera.
struct Input {
  opengv::bearingVectors_t rays;
  opengv::points_t points;

  explicit Input(const PoseTask& task) {
    for (const Correspondence& c : task.correspondences) {
      rays.push_back(ray_in_camera(task.camera.lens, c.pixel).value().direction.normalized());
      points.push_back(c.point);
    }
  }

  double squares(const opengv::transformation_t& target_from_camera) const {
    double sum = 0;
    const Eigen::Matrix3d rotation = target_from_camera.leftCols<3>().transpose();
    for (std::size_t i = 0; i < rays.size(); ++i)
      sum += ((rotation * (points[i] - target_from_camera.col(3))).normalized() - rays[i])
                 .squaredNorm();
    return sum;
  }

  PoseAnswer pose(bool refine) const {
    opengv::absolute_pose::CentralAbsoluteAdapter adapter(rays, points);
    double least = std::numeric_limits<double>::infinity();
    opengv::transformation_t best;
    for (const opengv::transformation_t& one : opengv::absolute_pose::upnp(adapter))
      if (const double sum = squares(one); sum < least) least = sum, best = one;
    if (!(least < std::numeric_limits<double>::infinity())) return {};
    if (refine) {
      adapter.setR(best.leftCols<3>());
      adapter.sett(best.col(3));
      best = opengv::absolute_pose::optimize_nonlinear(adapter);
    }
    if (!best.allFinite()) return {};
    const Eigen::Matrix3d turn = best.leftCols<3>().transpose();
    PoseAnswer found;
    found.success = true;
    found.camera_from_target = Pose(nearest_rotation(turn), -(turn * best.col(3)));
    return found;
  }
};

PoseMethod method(const std::string& name, const std::string& settings, bool refine) {
  return {name,
          [refine](const PoseTask& task) {
            return prepare_task<PoseAnswer>(
                Input(task), [refine](const Input& input) { return input.pose(refine); });
          },
          settings};
}

}  // namespace

std::vector<PoseMethod> opengv_poses() {
  return {method("OpenGV upnp", "of its solutions the one of least residuals", false),
          method("OpenGV upnp, refined", "upnp, then optimize_nonlinear", true)};
}

}  // namespace tagcal::study

#else

namespace tagcal::study {

std::vector<PoseMethod> opengv_poses() { return {}; }

}  // namespace tagcal::study

#endif
