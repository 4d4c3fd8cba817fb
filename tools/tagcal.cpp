// The command table, and the only place where errors end.

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <exception>
#include <string>
#include <vector>

#include "commands.hpp"
#include "tagcal/error.hpp"

namespace tagcal::tools {
namespace {

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

int report(const std::string& message) {
  fmt::print(stderr, "tagcal: {}\n", one_line(message));
  return kBadInput;
}

const Command* chosen(const std::vector<Command>& commands) {
  const auto found = std::find_if(commands.begin(), commands.end(),
                                  [](const Command& c) { return c.arguments->parsed(); });
  return found == commands.end() ? nullptr : &*found;
}

int run(int argc, char** argv) {
  CLI::App app("Where a camera is, how it projects, and how far to trust that.", "tagcal");
  app.set_version_flag("--version", "tagcal " TAGCAL_VERSION);
  app.require_subcommand(1, 1);
  app.footer(
      "Example: tagcal render scene.yaml --out desk && tagcal calibrate desk --out camera.yaml\n"
      "Exit codes: 0 an answer, 1 a check that fails, 2 bad input or usage, 3 no answer.");
  const std::vector<Command> commands = {add_render(app), add_detect(app), add_calibrate(app),
                                         add_validate(app), add_board(app)};
  try {
    app.parse(argc, argv);
    return chosen(commands)->run();
  } catch (const CLI::Success& help_or_version) {
    return app.exit(help_or_version);
  } catch (const CLI::ParseError& error) {
    const Command* command = chosen(commands);
    return report(fmt::format("{} (see tagcal {}--help)", one_line(error.what()),
                              command ? command->arguments->get_name() + " " : ""));
  } catch (const Error& error) {
    return report(error.what());
  } catch (const std::bad_alloc&) {
    return report("out of memory");
  } catch (const std::exception& error) {
    return report(error.what());
  }
}

}  // namespace
}  // namespace tagcal::tools

int main(int argc, char** argv) { return tagcal::tools::run(argc, argv); }
