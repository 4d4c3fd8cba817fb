// Maps of pose with focal length from one view.

#include "study/atlas/map_pose.hpp"
#include "study/chart/pose_methods.hpp"
#include "study/peers/pose_peers.hpp"
#include "study/tasks/pose_tasks.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector3d;

constexpr double kBoardWidth = 0.66;  // of the board, metres

PoseQuestion focal_question(PoseTask task) {
  PoseQuestion question = all_right(std::move(task));
  question.focal = question.plane = true;
  return question;
}

void ask_focal(StabilityMap& map,
               const std::function<PoseTask(std::span<const double>, Random&)>& draw) {
  std::vector<MapMethod> methods = {our_pose_and_focal(), our_pose_and_focal_of_unknown_noise(),
                                    peer(opencv_calibrate_camera())};
  for (const PoseMethod& m : pose_methods(PoseJob::plane_focal))
    if (m.name == "tagcal plane_pose_and_focal") methods.push_back(peer(m));
  ask_pose(map, methods, [draw](std::span<const double> at, Random& random) {
    return focal_question(draw(at, random));
  });
}

}  // namespace

StabilityMap focal_tilt_map() {
  StabilityMap map;
  map.name = "focal-tilt-noise";
  map.title = "Focal length from one view of a board (0.66 m, 36 corners) 1.2 m away";
  map.axes = {{"tilt", "deg", {0, 1, 2, 5, 10, 15, 20, 30, 45, 60}, {}},
              {"noise", "px", {0.05, 0.1, 0.2, 0.5, 1, 2}, {}}};
  map.what =
      "A plane that faces the camera looks the same from twice as far with twice the focal length";
  map.why =
      "Its image is a similarity, which holds f / Z only; sd(f) grows with the inverse square of "
      "the tilt (Sturm & Maybank, CVPR 1999; Zhang, PAMI 2000)";
  map.answer =
      "tagcal says `focal_not_observable` where sd(f) / f exceeds 10 % or weak perspective "
      "explains the view, and gives the pose under weak perspective";
  ask_focal(map, [](std::span<const double> at, Random& random) {
    ViewRange range{at[0], at[0], 1.2, 1.2, at[1]};
    range.aside = false;
    return draw_task(tag_grid_points(3), range, random);
  });
  return map;
}

StabilityMap focal_distance_map() {
  StabilityMap map;
  map.name = "focal-distance";
  map.title = "Focal length and distance: a board tilted by 40°, 0.5 px of noise";
  map.axes = {{"distance", "board widths", {1.5, 3, 6, 12, 25, 50, 100, 200, 600}, {}},
              {"width in the picture", "px", {30, 60, 125, 250, 500, 1000}, {}}};
  map.what =
      "From far away, with a long lens or of a small target, perspective fades, and focal length "
      "and distance become one number";
  map.why =
      "Depths differ by a share of size / distance only: scaled orthography (Hartley & Zisserman "
      "2004, chapter 6; Oberkampf, DeMenthon & Davis, CVIU 1996)";
  map.answer = "tagcal falls back to the scale f / Z, and says that it does";
  ask_focal(map, [](std::span<const double> at, Random& random) {
    PoseTask task;
    task.sigma_px = 0.5;
    task.camera = {pinhole(at[0] * at[1], at[0] * at[1], 639.5, 399.5), {1280, 800}};
    const double azimuth = random.uniform(0, 2 * std::numbers::pi);
    const double roll = random.uniform(0, 2 * std::numbers::pi);
    const Eigen::Quaterniond tilt =
        exp_rotation(40 * kDegree * Vector3d(std::cos(azimuth), std::sin(azimuth), 0));
    const Eigen::Quaterniond facing(0, 1, 0, 0);
    task.camera_from_target =
        Pose(tilt * facing * exp_rotation({0, 0, roll}), {0, 0, at[0] * kBoardWidth});
    see(tag_grid_points(3), task, random);
    return task;
  });
  return map;
}

}  // namespace tagcal::study
