#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "commands/handeye_input.hpp"
#include "commands/rig_input.hpp"
#include "job/arguments.hpp"
#include "job/find_corners.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "page_data/pages.hpp"
#include "report/handeye_report.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/handeye_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

struct HandeyeArguments : HandeyeSources {
  std::string robot;
  std::string robot_format;
  std::string mount;
  std::string times;
  std::string time_offset = "0";
  std::string out;
  std::string ros;
  std::string report;  // a page
  bool json = false;
};

void check_outputs(const HandeyeArguments& arguments) {
  check_yaml_writable(arguments.out);
  check_text_writable(arguments.ros);
  std::vector<std::string> inputs = {arguments.camera, arguments.robot, arguments.times};
  inputs.insert(inputs.end(), arguments.input.inputs.begin(), arguments.input.inputs.end());
  check_replaces_nothing({arguments.out, arguments.ros, arguments.report},
                         {inputs.begin(), inputs.end()});
  if (!arguments.report.empty()) check_page(arguments.report, inputs);
}

void write_files(const HandeyeArguments& arguments, const HandeyeEstimate& answer) {
  write_answer_file(arguments.out, handeye_yaml(answer));
  write_answer_file(arguments.ros, handeye_ros_text(answer));
}

// The inputs as the page names them.
std::vector<InputRow> input_rows(const HandeyeArguments& arguments) {
  std::vector<InputRow> rows = {{"camera", arguments.camera},
                                {"robot", arguments.robot},
                                {"robot's format", arguments.robot_format},
                                {"times", arguments.times}};
  std::erase_if(rows, [](const InputRow& row) { return row.text.empty(); });
  return rows;
}

int run(const HandeyeArguments& given) {
  HandeyeArguments arguments = given;
  check_outputs(arguments);
  arguments.input.other_outputs = {arguments.out, arguments.ros, arguments.report};
  const RobotPoses poses = read_robot_poses(arguments.robot, arguments.robot_format);
  HandeyeInput input = read_handeye(arguments);
  HandeyeOptions options;
  options.mount = arguments.mount == "hand" ? CameraMount::hand : CameraMount::base;
  options.sigma_px = arguments.sigma_px;
  options.find_time_offset = arguments.time_offset == "find";
  options.num_threads = static_cast<std::size_t>(arguments.threads);
  if (!input.boards.empty()) options.print = input.boards.front().board.substrate.print;
  add_robot_poses(arguments.robot, poses, arguments.times, input, options);
  HandeyeEstimate answer = naming(input.name, [&] {
    return input.camera ? calibrate_handeye(input.views, *input.camera, options)
                        : calibrate_handeye_from_poses(input.views, input.shared, options);
  });
  if (input.contradiction) answer.findings.insert(answer.findings.begin(), *input.contradiction);
  refuse(input.wrong_target, answer);
  const bool answered = is_answer(answer.status);
  if (answered) write_files(arguments, answer);
  if (!arguments.report.empty())
    write_page(arguments.report, handeye_page(input, input_rows(arguments), options, answer));
  print_answer(arguments.json ? handeye_json(answer, input) : handeye_summary(answer, input),
               arguments.json, answered ? arguments.out : "");
  for (const std::string& file : {arguments.out, arguments.ros})
    if (!answered) say_no_answer_file(file);
  return answered ? kAnswer : kNoAnswer;
}

// The robot's poses, and their times.
void add_robot(CLI::App& command, HandeyeArguments& arguments) {
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
             "times of the pictures (image,time_s), if poses have times and pictures have none")
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
  const auto arguments = std::make_shared<HandeyeArguments>();
  add_input(*command, arguments->input);
  add_observations(*command, arguments->input);
  add_option(*command, "--camera", arguments->camera,
             "the camera's file, or a rig's (a folder a camera); a file of poses has none")
      .text("CAMERA");
  add_pair(*command, arguments->pair).seldom();
  add_robot(*command, *arguments);
  add_positive(*command, "--sigma-px", arguments->sigma_px,
               "noise of the corners per coordinate; default: as for `pose`")
      .seldom();
  add_option(*command, "--out", arguments->out, "file for the answer, written if there is one")
      .text("FILE")
      .writes_text();
  add_option(*command, "--ros", arguments->ros, "a static transform of ROS: the camera's place")
      .text("FILE")
      .writes_text();
  add_option(*command, "--report", arguments->report,
             "a page: both places, the robot in 3D (report.md)")
      .text("FILE.html");
  add_flag(*command, "--json", arguments->json, "one JSON object on stdout");
  add_threads(*command, arguments->threads);
  add_footer(*command,
             "Example: tagcal handeye pictures --target board.yaml --camera camera.yaml\n"
             "           --robot poses.csv --mount hand --out handeye.yaml\n"
             "         tagcal handeye poses.json --robot poses.csv --mount hand");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
