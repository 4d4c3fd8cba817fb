// tagcal-study: the commands that compare with other libraries. `tagcal` starts it.

#include "job/command_line.hpp"
#include "job/messages.hpp"
#include "study/study_commands.hpp"

namespace tagcal::tools {
namespace {

std::vector<Command> command_table(CLI::App& app) { return {add_chart(app), add_stability(app)}; }

}  // namespace
}  // namespace tagcal::tools

int main(int argc, char** argv) {
  tagcal::tools::reserve_standard_streams();
  return tagcal::tools::run_command_line(argc, argv, tagcal::tools::command_table);
}
