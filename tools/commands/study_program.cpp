#include "commands/study_program.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "job/arguments.hpp"
#include "job/messages.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

struct StudyCommand {
  std::string_view name, description;
};
constexpr std::array<StudyCommand, 2> kStudyCommands = {
    {{"chart", "speed and accuracy of the methods of tagcal and other libraries"},
     {"stability", "maps of where the methods of tagcal and other libraries fail"}}};

}  // namespace

void add_study_commands(CLI::App& app, std::vector<Command>& commands) {
  for (const auto& [name, description] : kStudyCommands)
    commands.push_back(
        {add_command(app, std::string(name), std::string(description)), [] { return kBadInput; }});
}

bool is_study_command(int argc, char** argv) {
  return argc > 1 &&
         std::ranges::find(kStudyCommands, argv[1], &StudyCommand::name) != kStudyCommands.end();
}

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

}  // namespace tagcal::tools
