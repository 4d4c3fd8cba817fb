#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "commands/handeye_input.hpp"
#include "job/arguments.hpp"
#include "job/camera_input.hpp"
#include "job/find_corners.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "report/handeye_report.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/handeye_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

struct Arguments {
  InputArguments input;
  std::string camera;
  std::string robot;
  std::string robot_format;
  std::string mount;
  std::string times;
  std::string time_offset = "0";
  double sigma_px = 0;
  std::string out;
  std::string ros;
  int threads = 0;
  bool json = false;
};

// The views with a corner of the target, in the frame of a single board or in the world of several.
std::vector<HandeyeView> views_of(Input& input, const CalibrationFile& camera) {
  std::vector<PlacedBoard>& boards = input.dataset.boards;
  if (boards.size() == 1) boards[0].world_from_board = Pose();
  const auto points = points_in_world(boards);
  std::vector<HandeyeView> views;
  for (const View& view : input.dataset.views) {
    if (view.observations.empty()) continue;
    views.push_back(
        {view.image, view_correspondences(view, points, camera.camera_error_px), {}, {}});
  }
  return views;
}

void check_outputs(const Arguments& arguments) {
  check_text_writable(arguments.out);
  check_text_writable(arguments.ros);
  std::vector<std::filesystem::path> inputs = {arguments.camera, arguments.robot, arguments.times};
  inputs.insert(inputs.end(), arguments.input.inputs.begin(), arguments.input.inputs.end());
  check_replaces_nothing({arguments.out, arguments.ros}, inputs);
}

void write_files(const Arguments& arguments, const HandeyeEstimate& answer) {
  write_answer_file(arguments.out, handeye_yaml(answer));
  write_answer_file(arguments.ros, handeye_ros_text(answer));
}

int run(const Arguments& arguments) {
  check_outputs(arguments);
  const RobotPoses poses = read_robot_poses(arguments.robot, arguments.robot_format);
  Input input = read_input(arguments.input);
  const CalibrationFile camera = read_camera(arguments.camera);
  check_image_size(camera.camera.image_size, arguments.camera, input);
  find_views(input, arguments.threads, true, &camera.camera);
  print_warnings(input.warnings);
  HandeyeOptions options;
  options.mount = arguments.mount == "hand" ? CameraMount::hand : CameraMount::base;
  options.sigma_px = arguments.sigma_px;
  options.find_time_offset = arguments.time_offset == "find";
  options.num_threads = static_cast<std::size_t>(arguments.threads);
  const std::vector<HandeyeView> views = with_robot_poses(
      input, views_of(input, camera), arguments.robot, poses, arguments.times, options);
  const HandeyeEstimate answer = calibrate_handeye(views, uncertain_camera(camera), options);
  const bool answered = is_answer(answer.status);
  if (answered) write_files(arguments, answer);
  print_answer(arguments.json ? handeye_json(answer, views) : handeye_summary(answer, views),
               arguments.json, answered ? arguments.out : "");
  for (const std::string& file : {arguments.out, arguments.ros})
    if (!answered) say_no_answer_file(file);
  return answered ? kAnswer : kNoAnswer;
}

// The robot's poses, and their times.
void add_robot(CLI::App& command, Arguments& arguments) {
  add_option(command, "--robot", arguments.robot,
             "the robot's poses, hand in base: a table with a line a picture or a time, or a "
             "folder of ViSP's files")
      .required()
      .text("FILE|DIR");
  add_option(command, "--robot-format", arguments.robot_format,
             "its columns, if its first line does not name them: tum, or as 'image x_mm y_mm z_mm "
             "qw qx qy qz' (handeye.md)")
      .text("COLUMNS");
  add_option(command, "--mount", arguments.mount,
             "hand: the camera is on the hand; base: it is at rest, the board in the hand")
      .required()
      .one_of({"hand", "base"})
      .text("HOW");
  add_option(command, "--times", arguments.times,
             "times of the pictures (image,time_s), for poses with times")
      .text("CSV");
  add_option(command, "--time-offset", arguments.time_offset,
             "find: estimate what the pictures' times lack; 0 (the default): refuse clocks that "
             "differ")
      .one_of({"find", "0"})
      .text("HOW");
}

}  // namespace

Command add_handeye(CLI::App& app) {
  CLI::App* command =
      add_command(app, "handeye", "where a camera is on a robot's hand, or beside the robot");
  const auto arguments = std::make_shared<Arguments>();
  add_input(*command, arguments->input);
  add_observations(*command, arguments->input);
  add_option(*command, "--camera", arguments->camera,
             "the camera's file, of any format (tagcal convert)")
      .required()
      .text("CAMERA");
  add_robot(*command, *arguments);
  add_positive(*command, "--sigma-px", arguments->sigma_px,
               "noise of the corners per coordinate; default: as for `pose`")
      .seldom();
  add_option(*command, "--out", arguments->out, "file for the answer, written if there is one")
      .text("FILE")
      .writes_text();
  add_option(*command, "--ros", arguments->ros,
             "file for the camera's place as a static transform of ROS")
      .text("FILE")
      .writes_text();
  add_flag(*command, "--json", arguments->json, "one JSON object on stdout");
  add_threads(*command, arguments->threads);
  add_footer(*command,
             "Example: tagcal handeye pictures --target board.yaml --camera camera.yaml\n"
             "           --robot poses.csv --mount hand --out handeye.yaml");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
