// The map of poses over the unit of length and the distance from the origin.

#include "study/atlas/map_pose.hpp"
#include "study/peers/pose_peers.hpp"
#include "study/tasks/pose_tasks.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector3d;

// The same view in another unit of length, with another origin of the target's frame.
PoseTask moved(PoseTask task, double scale, const Vector3d& offset) {
  for (Correspondence& c : task.correspondences) c.point = scale * (c.point + offset);
  const Pose& pose = task.camera_from_target;
  task.camera_from_target =
      Pose(pose.rotation(), scale * (pose.translation() - pose.rotation() * offset));
  return task;
}

}  // namespace

StabilityMap units_map() {
  StabilityMap map;
  map.name = "units";
  map.title = "Units of length, and a target far from the origin of its frame, 0.5 px of noise";
  map.axes = {{"unit", "m", {1e-6, 1e-4, 1e-2, 1, 1e2, 1e4, 1e6}, {}},
              {"offset", "sizes", {0, 1, 1e2, 1e4, 1e6, 1e8}, {}}};
  map.what =
      "The same view in millimetres or kilometres, or in the frame of a map, is another problem to "
      "a solver that does not centre and scale";
  map.why =
      "Squares of coordinates lose the digits in which the target differs from its place, and "
      "thresholds without a unit are met by chance (Hartley, PAMI 1997)";
  map.answer =
      "tagcal solves in a frame about the points, of their size, so that neither unit nor origin "
      "changes the answer";
  map.exempt = {
      "the covariance at an origin 1e8 sizes away: sixteen digits do not hold it, so that ours is "
      "held to the bound here, as the peers are"};
  ask_pose(map,
           {our_pose(), peer(opencv_pose("SQPNP")), peer(opencv_pose("ITERATIVE")),
            peer(opencv_pose("EPNP")), aside(opencv_pose("IPPE"))},
           [](std::span<const double> at, Random& random) {
             const PoseTask task = draw_task(tag_grid_points(3), {}, random);
             const Vector3d direction =
                 Vector3d(random.normal(), random.normal(), random.normal()).normalized();
             PoseQuestion question = all_right(moved(task, at[0], 0.66 * at[1] * direction));
             question.by_bound = true;
             return question;
           });
  return map;
}

}  // namespace tagcal::study
