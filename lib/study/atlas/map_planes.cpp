// Maps of poses of planes: the two-fold ambiguity, and rotations by exactly 0 or 180 degrees.

#include <cmath>

#include "study/atlas/map_pose.hpp"
#include "study/peers/pose_peers.hpp"
#include "study/tasks/pose_tasks.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector3d;

constexpr double kTagSide = 0.088, kTagSigmaPx = 0.5;

double normal_tail(double x) { return 0.5 * std::erfc(x / std::sqrt(2.0)); }

// The closed form of docs/trust/how_sure.md and its reference: the residuals of the flipped pose
// over the eight coordinates are ||d|| = c(tilt) f L^2 / Z^2, and the flipped pose wins if the
// noise along d exceeds half of that.
std::optional<double> expected_flips(double tilt_deg, double distance_m) {
  if (tilt_deg < 20) return std::nullopt;  // the second minimum merges with the first
  const double s = std::sin(tilt_deg * kDegree);
  const double d = s * std::sqrt(1 - 0.4 * s * s) * kStudyFocalPx * kTagSide * kTagSide /
                   (distance_m * distance_m);
  return normal_tail(d / (2 * kTagSigmaPx));
}

enum TurnedTarget { plane_none, plane_half, tag_half, space_none, space_half };

// A target that is turned by nothing or by half a turn, and by this angle about a random axis.
PoseQuestion nearly_turned(TurnedTarget kind, double away_deg, Random& random) {
  const bool in_space = kind == space_none || kind == space_half;
  const bool half = kind == plane_half || kind == tag_half || kind == space_half;
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  PoseTask task;
  task.camera = study_camera();
  task.sigma_px = 1e-6;
  const Eigen::Quaterniond away =
      exp_rotation(away_deg * kDegree * Vector3d(std::cos(azimuth), std::sin(azimuth), 0));
  const Eigen::Quaterniond turned =
      half ? Eigen::Quaterniond(0, 1, 0, 0) : Eigen::Quaterniond::Identity();
  task.camera_from_target =
      Pose(away * turned, {random.uniform(-0.1, 0.1), random.uniform(-0.06, 0.06), 1.2});
  const std::vector<Vector3d> points = in_space           ? space_points(20, 0.6, random)
                                       : kind == tag_half ? square_points(0.3)
                                                          : tag_grid_points(3);
  see(points, task, random);
  return all_right(task);
}

}  // namespace

StabilityMap tag_tilt_distance_map() {
  StabilityMap map;
  map.name = "tag-tilt-distance";
  map.title = "One tag of 88 mm, 0.5 px of noise, f = 900 px: tilt and distance";
  map.axes = {{"tilt", "deg", {0, 2, 5, 10, 20, 30, 40, 50, 60, 70, 80}, {}},
              {"distance", "m", {0.25, 0.5, 0.75, 1, 1.5, 2, 3, 4}, {}}};
  map.what =
      "The picture of a small tilted square is nearly that of the square tilted the other way, so "
      "that the likeliest pose may be the mirrored one";
  map.why =
      "The two differ by their perspective alone, which falls with the square of size over "
      "distance (Schweighofer & Pinz, PAMI 2006; Collins & Bartoli, IJCV 2014)";
  map.answer =
      "tagcal refines both poses, gives both with their odds where the noise may have chosen, and "
      "widens the covariance of a tag that may face the camera";
  map.exempt = {
      "a square turned by a quarter, and the wrong id of a lone tag: the corners fit as well, so "
      "that only what the tag's bits say tells them apart",
      "a wrong size of the tag: the pose is the same, from another distance"};
  map.expected_flips = [](std::span<const double> at) { return expected_flips(at[0], at[1]); };
  ask_pose(map,
           {our_pose(), peer(opencv_pose("IPPE_SQUARE")), peer(opencv_pose("SQPNP")),
            peer(apriltag_pose()), aside(opencv_pose("ITERATIVE")), aside(opencv_pose("AP3P")),
            aside(opencv_pose("P3P")), aside(opencv_pose("EPNP"))},
           [](std::span<const double> at, Random& random) {
             ViewRange range{at[0], at[0], at[1], at[1], kTagSigmaPx};
             range.aside = false;
             PoseQuestion question = all_right(draw_task(square_points(kTagSide), range, random));
             question.plane = true;
             return question;
           });
  return map;
}

StabilityMap turns_map() {
  StabilityMap map;
  map.name = "turns";
  map.title = "Rotations next to none and to half a turn, noise 1e-6 px";
  map.axes = {{"away by", "deg", {0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3, 0.1, 1, 10}, {}},
              {"target",
               "",
               {plane_none, plane_half, tag_half, space_none, space_half},
               {"plane, 0°", "plane, 180°", "tag, 180°", "space, 0°", "space, 180°"}}};
  map.what =
      "A target that is turned by exactly nothing or by exactly half a turn, as every synthetic "
      "test begins, makes divisions by zero";
  map.why =
      "A rotation vector has no derivative at half a turn, and a plane that faces the camera has "
      "its two poses in one (Rodrigues; Collins & Bartoli, IJCV 2014, section 3.2)";
  map.answer =
      "tagcal keeps rotations as quaternions and steps on the manifold, and its closed forms are "
      "exact where the two poses are one";
  map.exempt = {
      "OpenCV IPPE takes planes only: that it refuses points in space is no fault of its"};
  ask_pose(map,
           {our_pose(), peer(opencv_pose("IPPE")), peer(opencv_pose("EPNP")),
            peer(opencv_pose("ITERATIVE")), aside(opencv_pose("SQPNP"))},
           [](std::span<const double> at, Random& random) {
             return nearly_turned(static_cast<TurnedTarget>(at[1]), at[0], random);
           });
  return map;
}

}  // namespace tagcal::study
