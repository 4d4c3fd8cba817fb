// Maps of poses: number and arrangement of the points.

#include <algorithm>
#include <cmath>

#include "study/atlas/map_pose.hpp"
#include "study/peers/pose_peers.hpp"
#include "study/tasks/pose_tasks.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector3d;

constexpr double kSize = 0.6;  // of the targets, metres

// Random points in a box of `size` metres about the origin.
std::vector<Vector3d> box_points(std::size_t n, const Vector3d& size, Random& random) {
  std::vector<Vector3d> points = space_points(n, 1, random);
  for (Vector3d& p : points) p = p.cwiseProduct(size);
  return points;
}

// Points a share of which are behind the camera.
PoseQuestion behind_camera(double share, std::size_t n, Random& random) {
  PoseTask task = draw_task({}, {}, random);
  std::vector<Vector3d> points = space_points(n, kSize, random);
  const auto behind =
      some_of(n, static_cast<std::size_t>(std::lround(share * static_cast<double>(n))), random);
  // Reflects a point through the camera's centre: it has the same image at x / z.
  const Vector3d camera = task.camera_from_target.inverse().translation();
  for (const std::size_t i : behind) points[i] = 2 * camera - points[i];
  see(points, task, random);
  PoseQuestion question;
  for (std::size_t i = 0; i < n; ++i)
    if (!std::binary_search(behind.begin(), behind.end(), i)) question.right.push_back(i);
  question.knowable = beyond_chance(n, question.right.size(), task.sigma_px);
  question.task = std::move(task);
  return question;
}

}  // namespace

StabilityMap flatness_map() {
  StabilityMap map;
  map.name = "flatness";
  map.title = "From a plane to a cube, 0.5 px of noise: thickness and number of points";
  map.axes = {{"thickness", "of the width", {0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.3, 1}, {}},
              {"points", "", {6, 20, 100}, {}}};
  map.what =
      "Between a plane and a body, solvers for the one are no longer right and those for the other "
      "not yet";
  map.why =
      "EPnP's fourth control point and the direct linear transformation lose their rank as the "
      "points become flat (Lepetit, Moreno-Noguer & Fua, IJCV 2009; Hartley & Zisserman 2004, "
      "section 7.1), and IPPE takes planes only";
  map.answer =
      "tagcal picks its start by the measured spread of the points and ends at the same maximum of "
      "likelihood from each";
  map.exempt = {
      "OpenCV IPPE takes planes only: that it refuses points in space is no fault of its"};
  ask_pose(map,
           {our_pose(), peer(opencv_pose("EPNP")), peer(opencv_pose("ITERATIVE")),
            peer(opencv_pose("SQPNP")), aside(opencv_pose("IPPE"))},
           [](std::span<const double> at, Random& random) {
             const auto points =
                 box_points(static_cast<std::size_t>(at[1]), kSize * Vector3d(1, 1, at[0]), random);
             PoseQuestion question = all_right(draw_task(points, {}, random));
             question.plane = at[0] < 0.01;
             return question;
           });
  return map;
}

StabilityMap line_map() {
  StabilityMap map;
  map.name = "line";
  map.title = "Points nearly on a line, 0.5 px of noise: width and number of points";
  map.axes = {
      {"width", "of the length", {0, 1e-7, 1e-5, 1e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3}, {}},
      {"points", "", {4, 10, 50}, {}}};
  map.what = "Of points on a line the turn about that line cannot be seen";
  map.why =
      "Every such turn leaves the points where they are, so that the information has rank five "
      "(Hartley & Zisserman 2004, section 7.1)";
  map.answer =
      "tagcal calls points on a line `degenerate`, and of points near one it gives the turn with "
      "the standard deviation that it has";
  ask_pose(map,
           {our_pose(), peer(opencv_pose("SQPNP")), peer(opencv_pose("EPNP")),
            peer(opencv_pose("ITERATIVE"))},
           [](std::span<const double> at, Random& random) {
             const auto points = box_points(static_cast<std::size_t>(at[1]),
                                            kSize * Vector3d(1, at[0], at[0]), random);
             return all_right(draw_task(points, {}, random));
           });
  return map;
}

StabilityMap points_map() {
  enum Kind { plane, space };
  StabilityMap map;
  map.name = "points";
  map.title = "The number of points, 0.5 px of noise";
  map.axes = {{"points", "", {3, 4, 5, 6, 8, 12, 20, 50, 100, 300, 1000}, {}},
              {"target", "", {plane, space}, {"plane", "space"}}};
  map.what = "Three points have up to four poses, and few points leave solvers little to lean on";
  map.why =
      "Three points give as many equations as a pose has unknowns, of degree four (Haralick et "
      "al., IJCV 1994; Gao et al., PAMI 2003)";
  map.answer = "tagcal takes four points or more, and with four in space it names a second pose";
  map.trials = 3000;
  ask_pose(map,
           {our_pose(), our_pose_of_unknown_noise(), peer(opencv_pose("SQPNP")),
            peer(opencv_pose("EPNP")), aside(opencv_pose("ITERATIVE")), aside(opencv_pose("AP3P"))},
           [](std::span<const double> at, Random& random) {
             const bool flat = static_cast<int>(at[1]) == plane;
             const auto points = box_points(static_cast<std::size_t>(at[0]),
                                            kSize * Vector3d(1, 1, flat ? 0 : 1), random);
             PoseQuestion question = all_right(draw_task(points, {}, random));
             question.plane = flat;
             return question;
           });
  return map;
}

StabilityMap near_camera_map() {
  StabilityMap map;
  map.name = "near-camera";
  map.title = "Points next to the camera, 20 in all, 0.5 px of noise";
  map.axes = {{"nearest depth", "m", {1e-3, 0.003, 0.01, 0.03, 0.1, 0.3}, {}},
              {"share of points that near", "", {0.05, 0.25, 0.5}, {}}};
  map.what =
      "Some points are at arm's length and others next to the lens, so that a small step of a "
      "solver takes one behind the camera";
  map.why =
      "The image moves by f / z for every unit of length, and solvers that weigh errors in space "
      "or linear equations count near points too little (Lu, Hager & Mjolsness, PAMI 2000)";
  map.answer =
      "tagcal weighs each point by its error in the picture and takes no step that puts a point "
      "behind the camera";
  ask_pose(map,
           {our_pose(), peer(opencv_pose("SQPNP")), peer(opencv_pose("EPNP")),
            peer(opencv_pose("ITERATIVE"))},
           [](std::span<const double> at, Random& random) {
             constexpr std::size_t kPoints = 20;
             PoseTask task;
             task.camera = study_camera();
             task.sigma_px = 0.5;
             const Vector3d axis(random.normal(), random.normal(), random.normal());
             task.camera_from_target = Pose(exp_rotation(axis), {0, 0, at[0] + 0.3});
             const Pose target_from_camera = task.camera_from_target.inverse();
             const auto near = static_cast<std::size_t>(std::lround(at[1] * kPoints));
             std::vector<Vector3d> points;
             for (std::size_t i = 0; i < kPoints; ++i) {
               const double z = i < near ? at[0] : at[0] + kSize * random.uniform();
               const Vector3d ray((random.uniform(0, 1280) - 639.5) / kStudyFocalPx,
                                  (random.uniform(0, 800) - 399.5) / kStudyFocalPx, 1);
               points.push_back(target_from_camera * Vector3d(z * ray));
             }
             see(points, task, random);
             return all_right(task);
           });
  return map;
}

StabilityMap behind_camera_map() {
  StabilityMap map;
  map.name = "behind-camera";
  map.title = "Points behind the camera, mirrored into the picture as x / z has them";
  map.axes = {{"share behind", "", {0, 0.1, 0.25, 0.5, 0.75, 0.9, 1}, {}},
              {"points", "", {10, 20, 40}, {}}};
  map.what =
      "A point behind the camera divides by its negative depth into a picture where it never is, "
      "and a pose with all points behind fits such data exactly";
  map.why =
      "x / z is the same for a point and its mirror image through the camera: the linear equations "
      "know no front (Hartley & Zisserman 2004, chapter 21)";
  map.answer =
      "tagcal answers with poses that have every point they use in front, leaves the others out by "
      "name, and says `no_consensus` or `degenerate` where too few are left";
  map.exempt = {
      "a plane that is behind the camera as a whole: its mirrored picture is that of the plane in "
      "front, turned by half a turn about the line of sight"};
  ask_pose(map,
           {our_pose(), peer(opencv_pose("EPNP")), peer(opencv_pose("SQPNP")),
            peer(opencv_ransac("solvePnPRansac")), aside(opencv_pose("ITERATIVE"))},
           [](std::span<const double> at, Random& random) {
             return behind_camera(at[0], static_cast<std::size_t>(at[1]), random);
           });
  return map;
}

}  // namespace tagcal::study
