// The command table.

#include "commands/commands.hpp"
#include "commands/study_program.hpp"
#include "job/command_line.hpp"
#include "job/messages.hpp"

namespace tagcal::tools {
namespace {

std::vector<Command> command_table(CLI::App& app) {
  std::vector<Command> commands = {add_render(app),    add_detect(app),  add_calibrate(app),
                                   add_rig(app),       add_watch(app),   add_validate(app),
                                   add_report(app),    add_pose(app),    add_board(app),
                                   add_view(app),      add_diff(app),    add_convert(app),
                                   add_reproject(app), add_project(app), add_unproject(app)};
  add_study_commands(app, commands);
  commands.push_back(add_completion(app));
  return commands;
}

}  // namespace
}  // namespace tagcal::tools

int main(int argc, char** argv) {
  using namespace tagcal::tools;
  reserve_standard_streams();
  if (is_study_command(argc, argv)) return run_study_program(argv);
  return run_command_line(argc, argv, command_table);
}
