// The command table.

#include "commands/commands.hpp"
#include "commands/study_program.hpp"
#include "job/command_line.hpp"
#include "job/messages.hpp"
#include "tagcal/version.hpp"

namespace tagcal::tools {
namespace {

constexpr const char* kGuide =
    "tagcal " TAGCAL_VERSION
    ": where a camera is, how it projects, and how far to trust that\n\n"
    "print a target\n"
    "  tagcal board board.yaml --out board.pdf --paper a4\n"
    "calibrate from pictures, and look at the answer\n"
    "  tagcal calibrate --target board.yaml photos --out camera.yaml\n"
    "  tagcal report camera.yaml --target board.yaml photos\n"
    "while taking pictures\n"
    "  tagcal watch photos --target board.yaml --until 0.1px\n"
    "where a camera was\n"
    "  tagcal pose --camera camera.yaml --target board.yaml photo.jpg\n"
    "if a calibration is still valid\n"
    "  tagcal check --camera camera.yaml --target board.yaml new_photos\n"
    "find corners only\n"
    "  tagcal detect --target board.yaml photos --out corners.csv\n"
    "remove the distortion\n"
    "  tagcal reproject --camera camera.yaml photo.jpg --undistort all --out flat\n"
    "for other programs\n"
    "  tagcal convert camera.yaml camera.ros.yaml --to ros\n"
    "compare two calibrations, one with OpenCV, or many cameras\n"
    "  tagcal diff monday.yaml friday.yaml\n"
    "  tagcal validate camera.yaml --dataset desk\n"
    "  tagcal fleet cameras\n"
    "try it without a camera\n"
    "  tagcal render scene.yaml --out desk\n\n"
    "tagcal --help lists all commands, tagcal help COMMAND the options of one.\n";

std::vector<Command> command_table(CLI::App& app) {
  std::vector<Command> commands = {
      add_render(app),    add_detect(app),  add_calibrate(app), add_rig(app),
      add_handeye(app),   add_watch(app),   add_validate(app),  add_check(app),
      add_history(app),   add_report(app),  add_pose(app),      add_board(app),
      add_view(app),      add_diff(app),    add_fleet(app),     add_convert(app),
      add_reproject(app), add_project(app), add_unproject(app), add_triangulate(app)};
  add_study_commands(app, commands);
  commands.push_back(add_completion(app));
  return commands;
}

}  // namespace
}  // namespace tagcal::tools

int main(int argc, char** argv) {
  using namespace tagcal::tools;
  reserve_standard_streams();
  read_help_word(argc, argv);
  if (is_study_command(argc, argv)) return run_study_program(argv);
  return run_command_line(
      argc, argv, command_table,
      {"Camera calibration and poses from pictures of targets, with their uncertainty.", kGuide,
       "Example: tagcal calibrate --target board.yaml photos --out camera.yaml"});
}
