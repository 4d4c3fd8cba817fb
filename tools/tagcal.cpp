// The command table.

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "commands/commands.hpp"
#include "job/arguments.hpp"
#include "job/command_line.hpp"
#include "job/messages.hpp"
#include "tagcal/version.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

// `tagcal chart` and `tagcal stability` live in a program of their own beside this one,
// tagcal-study, which links the libraries that they compare with.
struct StudyCommand {
  std::string_view name, description;
};
constexpr std::array<StudyCommand, 2> kStudyCommands = {
    {{"chart", "speed and accuracy of the methods of tagcal and other libraries"},
     {"stability", "maps of where the methods of tagcal and other libraries fail"}}};

// Adds its commands to the table for the help text only: main() passes the command line on.
void add_study_commands(CLI::App& app, std::vector<Command>& commands) {
  for (const auto& [name, description] : kStudyCommands)
    commands.push_back(
        {add_command(app, std::string(name), std::string(description)), [] { return kBadInput; }});
}

bool is_study_command(int argc, char** argv) {
  return argc > 1 &&
         std::ranges::find(kStudyCommands, argv[1], &StudyCommand::name) != kStudyCommands.end();
}

// Replaces this process by tagcal-study. If that program is missing, prints how to build it and
// returns exit code 2.
int run_study_program(char** argv) {
  std::error_code error;
  const fs::path own = fs::read_symlink("/proc/self/exe", error);
  const fs::path program = (error ? fs::path(argv[0]) : own).parent_path() / "tagcal-study";
  execv(program.c_str(), argv);
  print_to_stderr(
      "tagcal: {}: needs the program {}; build it with: cmake --build --preset release --target "
      "tagcal_study_command\n",
      argv[1], program.string());
  return kBadInput;
}

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
