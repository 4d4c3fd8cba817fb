#include <memory>
#include <string>

#include "commands/commands.hpp"
#include "job/arguments.hpp"
#include "job/manual.hpp"
#include "job/messages.hpp"
#include "tagcal/error.hpp"

namespace tagcal::tools {
namespace {

struct CompletionArguments {
  std::string shell;
  std::string share;
};

int run(const CLI::App& app, const CompletionArguments& arguments) {
  if (arguments.shell.empty() == arguments.share.empty())
    throw Error("completion: needs either a shell (bash, zsh or fish) or --share");
  const std::vector<ManualCommand> commands = manual_commands(app);
  if (!arguments.share.empty())
    write_manual(arguments.share, commands);
  else
    print_result(completion(commands, arguments.shell));
  return kAnswer;
}

}  // namespace

Command add_completion(CLI::App& app) {
  CLI::App* command =
      add_command(app, "completion", "completion of commands and options in a shell");
  const auto arguments = std::make_shared<CompletionArguments>();
  add_option(*command, "SHELL", arguments->shell, "the shell").one_of({"bash", "zsh", "fish"});
  add_option(*command, "--share", arguments->share,
             "write the manual pages and the completions of all shells below this folder, such as "
             "/usr/local/share")
      .text("DIR");
  add_footer(*command, "Example: source <(tagcal completion bash)");
  return {command, [&app, arguments] { return run(app, *arguments); }};
}

}  // namespace tagcal::tools
