#include "commands/study_program.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "input/arguments.hpp"
#include "report/messages.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 2> kStudyCommands = {"chart", "stability"};

}  // namespace

Command add_study_command(CLI::App& app, const std::string& name, const std::string& description) {
  return {add_command(app, name, description), [] { return kBadInput; }};
}

bool is_study_command(int argc, char** argv) {
  return argc > 1 && std::ranges::find(kStudyCommands, argv[1]) != kStudyCommands.end();
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
