#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "python/arguments.hpp"
#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/boards.hpp"
#include "python/calibration.hpp"
#include "python/findings.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "python/uncertain_camera.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/handeye.hpp"
#include "tagcal/io/handeye_file.hpp"
#include "tagcal/io/robot_poses.hpp"
#include "tagcal/io/types.hpp"

// Cameras on robots.

namespace tagcal::python {
namespace {

using Times = std::optional<std::vector<double>>;

std::vector<Pose> poses_of(const std::vector<PoseLike>& poses, const char* name) {
  std::vector<Pose> all;
  for (const PoseLike& pose : poses) all.push_back(pose_of(pose, name));
  return all;
}

// The robot of a call, and how it carries the camera.
struct Robot {
  std::vector<HandeyeView> views;  // with the robot's poses and times alone
  HandeyeOptions options;
};

Robot robot_of(std::size_t num_views, const std::vector<PoseLike>& robot, const std::string& mount,
               const Times& times_s, const Times& robot_times_s, bool find_time_offset,
               int threads) {
  if (mount != "hand" && mount != "base")
    throw Error("mount: must be \"hand\" or \"base\", got \"" + mount + "\"");
  check_threads(threads);
  if (!robot_times_s && robot.size() != num_views)
    throw Error("base_from_hand: must have " + std::to_string(num_views) +
                " poses, one a view, got " + std::to_string(robot.size()));
  if (times_s && times_s->size() != num_views)
    throw Error("times_s: must have " + std::to_string(num_views) + " numbers, one a view, got " +
                std::to_string(times_s->size()));
  const std::vector<Pose> base_from_hand = poses_of(robot, "base_from_hand");
  Robot read;
  read.options.mount = mount == "hand" ? CameraMount::hand : CameraMount::base;
  read.options.find_time_offset = find_time_offset;
  read.options.num_threads = static_cast<std::size_t>(threads);
  if (robot_times_s) read.options.path = RobotPath{*robot_times_s, base_from_hand};
  for (std::size_t i = 0; i < num_views; ++i)
    read.views.push_back({std::to_string(i),
                          {},
                          robot_times_s ? Pose() : base_from_hand[i],
                          times_s ? std::optional((*times_s)[i]) : std::nullopt});
  return read;
}

HandeyeEstimate calibrate_views(const std::vector<View>& views, const TargetLike& target,
                                const CameraLike& camera,
                                const std::vector<PoseLike>& base_from_hand,
                                const std::string& mount, const Times& times_s,
                                const Times& robot_times_s, bool find_time_offset, double sigma_px,
                                int threads) {
  Robot robot = robot_of(views.size(), base_from_hand, mount, times_s, robot_times_s,
                         find_time_offset, threads);
  robot.options.sigma_px = sigma_px;
  const CalibrationFile known = known_camera(camera, "camera");
  const std::vector<PlacedBoard> boards = boards_of(target, "target");
  for (std::size_t i = 0; i < views.size(); ++i) {
    robot.views[i].image = views[i].image;
    robot.views[i].seen = view_correspondences(views[i], boards, known.camera_error_px);
  }
  if (!boards.empty()) robot.options.print = boards.front().board.substrate.print;
  const UncertainCamera lens = uncertain_camera(known);
  py::gil_scoped_release release;
  return calibrate_handeye(robot.views, lens, robot.options);
}

// PoseEstimate, RigPoseEstimate, (pose, covariance), or None.
using SeenPoseLike = Argument<"SeenPoseLike">;

std::vector<SeenPose> seen_poses(py::handle pose, bool has_rig) {
  std::vector<SeenPose> seen;
  if (pose.is_none()) return seen;
  if (py::isinstance<PoseEstimate>(pose)) {
    const auto& estimate = py::cast<const PoseEstimate&>(pose);
    if (is_answer(estimate.status))
      for (const PoseHypothesis& h : estimate.hypotheses)
        seen.push_back({h.camera_from_target, h.noise_covariance});
    return seen;
  }
  if (py::isinstance<RigPoseEstimate>(pose)) {
    if (!has_rig) throw Error("rig: is missing, which poses of a rig need");
    const auto& estimate = py::cast<const RigPoseEstimate&>(pose);
    return is_answer(estimate.rig.status) ? estimate.parts : seen;
  }
  if (!py::isinstance<py::tuple>(pose) || py::len(pose) != 2)
    throw Error("poses: must be PoseEstimate, RigPoseEstimate, (pose, covariance) or None, got " +
                type_name(pose));
  const auto parts = py::reinterpret_borrow<py::tuple>(pose);
  return {{pose_of(parts[0], "poses"),
           covariance_matrices(ArrayLike(parts[1]), "poses", 1, 6).front()}};
}

HandeyeEstimate calibrate_poses(const std::vector<SeenPoseLike>& poses,
                                const std::vector<PoseLike>& base_from_hand,
                                const std::string& mount, const std::optional<KnownRig>& rig,
                                const Times& times_s, const Times& robot_times_s,
                                bool find_time_offset, int threads) {
  Robot robot = robot_of(poses.size(), base_from_hand, mount, times_s, robot_times_s,
                         find_time_offset, threads);
  for (std::size_t i = 0; i < poses.size(); ++i)
    robot.views[i].poses = seen_poses(poses[i], rig.has_value());
  const MatrixX shared = rig ? rig->covariance : MatrixX();
  py::gil_scoped_release release;
  return calibrate_handeye_from_poses(robot.views, shared, robot.options);
}

std::string handeye_text(const HandeyeEstimate& h) {
  if (!is_answer(h.status)) return refusal(h.status, h.findings);
  return std::string(status_name(h.status)) + ", " + counted(h.views.size(), "pose") + ", robot " +
         number(1e3 * h.robot_sigma_m, 2) + " mm" +
         (h.num_corners > 0 ? ", rms " + number(h.rms_px, 3) + " px" : "") +
         warnings_text(h.findings);
}

void bind_handeye_parts(py::module_& m) {
  Record<RobotPoses> robot(m, "RobotPoses", "Poses of a robot's hand, by picture or time.");
  robot.field("images", &RobotPoses::images, "Names of the pictures; empty: not known.");
  robot.field("times_s", &RobotPoses::times_s, "Times; empty: not known.");
  robot.field("base_from_hand", &RobotPoses::base_from_hand, "A list of Pose.");
  robot.representation(
      [](const RobotPoses& r) { return counted(r.base_from_hand.size(), "pose"); });
  Record<HandeyeViewFit> view(m, "HandeyeView", "One view of a hand-eye calibration.");
  view.field("view", &HandeyeViewFit::view, "Index of the view.");
  view.field("base_from_hand", &HandeyeViewFit::base_from_hand, "Pose, corrected by the camera.");
  view.field("error_m", &HandeyeViewFit::error_m, "Distance of the robot's pose from it.");
  view.field("error_rad", &HandeyeViewFit::error_rad, "Angle of the robot's pose from it.");
  view.field("score", &HandeyeViewFit::score, "Of these errors, in standard deviations.");
  view.field("rms_px", &HandeyeViewFit::rms_px, "sqrt(sum |r|^2 / corners).");
  Record<RobotReading> reading(m, "RobotReading", "Another reading of the robot's poses.");
  reading.field("change", &RobotReading::change, "What it changes.");
  reading.field("times_better", &RobotReading::times_better, "Ratio of the disagreements.");
  Record<AdvisedRobotPose> next(m, "AdvisedRobotPose", "A pose of the robot to take next.");
  next.field("sentence", &AdvisedRobotPose::sentence, "For users.");
  next.field("base_from_hand", &AdvisedRobotPose::base_from_hand, "Pose.");
  next.field("sigma_m", &AdvisedRobotPose::sigma_m,
             "Standard deviation of the camera's place after it, in its worst direction.");
  next.field("sigma_now_m", &AdvisedRobotPose::sigma_now_m, "The same without it.");
  next.field("sigma_rad", &AdvisedRobotPose::sigma_rad, "The same of the rotation after it.");
  next.field("sigma_now_rad", &AdvisedRobotPose::sigma_now_rad, "The same without it.");
}

void bind_handeye_answer(py::module_& m) {
  Record<HandeyeEstimate> h(m, "HandeyeCalibration", "A camera on a robot, and how sure that is.");
  h.field("status", &HandeyeEstimate::status,
          "\"ok\" is an answer; \"rotation_axes_parallel\", \"no_rotation\", \"wrong_direction\", "
          "\"not_synchronous\" and those of a Calibration are none.");
  h.field("mount", &HandeyeEstimate::mount, "\"hand\" or \"base\".");
  h.field("mount_from_camera", &HandeyeEstimate::mount_from_camera,
          "Pose of the camera in the hand, or in the base.");
  h.field("holder_from_board", &HandeyeEstimate::holder_from_board,
          "Pose of the board in the base, or in the hand.");
  h.field("covariance", &HandeyeEstimate::covariance,
          "(12, 12), of (omega rad, tau m) of the one and the other.");
  h.field("board_scale", &HandeyeEstimate::board_scale,
          "The board's lengths by the robot's, over those of its file.");
  h.field("sigma_board_scale", &HandeyeEstimate::sigma_board_scale, "Its standard deviation.");
  h.field("robot_sigma_m", &HandeyeEstimate::robot_sigma_m,
          "Standard deviation of the robot's positions per axis, estimated.");
  h.field("robot_sigma_rad", &HandeyeEstimate::robot_sigma_rad, "The same of its rotations.");
  h.field("degrees_of_freedom", &HandeyeEstimate::degrees_of_freedom, "Behind the robot's noise.");
  h.field("axis_spread_rad", &HandeyeEstimate::axis_spread_rad,
          "Spread of the rotation axes; 0: one axis, pi / 4: two alike.");
  h.field("rotation_rad", &HandeyeEstimate::rotation_rad, "RMS rotation about the main axis.");
  h.field("board_spread_m", &HandeyeEstimate::board_spread_m,
          "Where single views put the board's centre: RMS distance from their mean.");
  h.field("rms_px", &HandeyeEstimate::rms_px, "sqrt(sum |r|^2 / corners).");
  h.field("num_corners", &HandeyeEstimate::num_corners, "That take part.");
  h.field("views", &HandeyeEstimate::views, "A list of HandeyeView, those that take part.");
  h.field("rejected", &HandeyeEstimate::rejected, "Views that contradict the others, by index.");
  h.field("unusable", &HandeyeEstimate::unusable, "Views without a pose, by index.");
  h.field("reading", &HandeyeEstimate::reading, "RobotReading that fits much better, or None.");
  h.field("time_offset_s", &HandeyeEstimate::time_offset_s,
          "To be added to the views' times; None without a path.");
  h.field("sigma_time_offset_s", &HandeyeEstimate::sigma_time_offset_s, "Its standard deviation.");
  h.field("next", &HandeyeEstimate::next, "AdvisedRobotPose, or None.");
  h.field("findings", &HandeyeEstimate::findings, "What the estimate found out about its data.");
  h.field("seconds", &HandeyeEstimate::seconds, "Wall-clock time.");
  define_file_answer(
      h, &handeye_yaml,
      "The text of a file, as `tagcal handeye --out` writes it. Raises Error without an answer.",
      &handeye_text);
}

}  // namespace

void bind_handeye(py::module_& m) {
  bind_handeye_parts(m);
  bind_handeye_answer(m);
  m.def(
      "read_robot_poses",
      [](const std::filesystem::path& file, const std::string& columns) {
        py::gil_scoped_release release;
        return read_robot_poses(file, columns);
      },
      py::arg("file"), py::arg("columns") = "",
      "RobotPoses of a table (CSV, TUM, ROS), or of a folder of ViSP's files. columns: as "
      "`tagcal handeye --robot-format`.");
  m.def("calibrate_handeye", &calibrate_views, py::arg("views"), py::arg("target"),
        py::arg("camera"), py::arg("base_from_hand"), py::arg("mount"), py::kw_only(),
        py::arg("times_s") = py::none(), py::arg("robot_times_s") = py::none(),
        py::arg("find_time_offset") = false, py::arg("sigma_px") = 0.0, py::arg("threads") = 1,
        "Where a camera is on a robot's hand, or beside the robot.\n\n"
        "mount: \"hand\" (the board is at rest) or \"base\" (the board is in the hand).\n"
        "views: a list of View.\n"
        "base_from_hand: the robot's Pose of each view; or, with their times robot_times_s, of a "
        "path, in which the views are at times_s.\n"
        "find_time_offset: estimate what is to be added to times_s.\n"
        "threads: 0: one per core; the answer does not depend on it.");
  m.def("calibrate_handeye_from_poses", &calibrate_poses, py::arg("poses"),
        py::arg("base_from_hand"), py::arg("mount"), py::kw_only(), py::arg("rig") = py::none(),
        py::arg("times_s") = py::none(), py::arg("robot_times_s") = py::none(),
        py::arg("find_time_offset") = false, py::arg("threads") = 1,
        "The same from poses of the board, each by its covariance.\n\n"
        "poses: of each view a PoseEstimate; a RigPoseEstimate; camera_from_board and its "
        "covariance (6, 6), of (omega rad, tau m), that another program estimated; or None.\n"
        "rig: the KnownRig of RigPoseEstimates: the camera of the answer is its frame.\n"
        "The rest is as for calibrate_handeye. rms_px is NaN.");
}

}  // namespace tagcal::python
