#include "job/command_line.hpp"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <exception>
#include <filesystem>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "job/interruption.hpp"
#include "job/messages.hpp"
#include "job/terminal.hpp"
#include "tagcal/error.hpp"
#include "tagcal/version.hpp"

namespace tagcal::tools {
namespace {

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

int report(const std::string& message) {
  print_to_stderr("tagcal: {}\n", one_line(message));
  return kBadInput;
}

const Command* chosen(const std::vector<Command>& commands) {
  const auto found = std::find_if(commands.begin(), commands.end(),
                                  [](const Command& c) { return c.arguments->parsed(); });
  return found == commands.end() ? nullptr : &*found;
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t change = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({change, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

// " (did you mean X?)" for one or two wrong letters.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& known) {
  for (const std::string& name : known) {
    if (edit_distance(word, name) <= 2) return fmt::format(" (did you mean {}?)", name);
  }
  return "";
}

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

// Message about the first argument that no command and no option takes.
std::string unexpected(const CLI::App& app, const CLI::App& command) {
  const std::vector<std::string> extra = app.remaining(true);
  const auto option = std::find_if(extra.begin(), extra.end(),
                                   [](const std::string& word) { return word.starts_with('-'); });
  if (option == extra.end()) return fmt::format("{}: not expected", extra.front());
  const std::string name = option->substr(0, option->find('='));
  return fmt::format("{}: unknown option{}", name, did_you_mean(name, option_names(command)));
}

// One line for each of CLI11's usage errors.
std::string usage_error(const CLI::ParseError& error, const CLI::App& app,
                        const std::vector<Command>& commands) {
  if (const Command* command = chosen(commands)) {
    const CLI::App& arguments = *command->arguments;
    const std::vector<std::string> words = app.remaining(true);
    const bool has_option = std::ranges::any_of(words, [](const auto& w) { return w[0] == '-'; });
    const bool extra = dynamic_cast<const CLI::ExtrasError*>(&error)
                           ? !words.empty()
                           : dynamic_cast<const CLI::RequiredError*>(&error) && has_option;
    return fmt::format("{}; see tagcal {} --help",
                       extra ? unexpected(app, arguments) : error.what(), arguments.get_name());
  }
  const std::vector<std::string> extra = app.remaining();
  std::vector<std::string> names;
  for (const Command& command : commands) names.push_back(command.arguments->get_name());
  if (extra.empty()) return fmt::format("needs a command: {}", fmt::join(names, ", "));
  return fmt::format("{}: unknown command{}; known: {}", extra.front(),
                     did_you_mean(extra.front(), names), fmt::join(names, ", "));
}

constexpr std::string_view kGuide =
    "tagcal " TAGCAL_VERSION
    ": where a camera is, how it projects, and how far to trust that\n\n"
    "  print a target              tagcal board board.yaml --out board.pdf --paper a4\n"
    "  calibrate from pictures     tagcal calibrate --target board.yaml photos/*.jpg --out "
    "camera.yaml\n"
    "  while taking pictures       tagcal watch photos --target board.yaml --until 0.1px\n"
    "  where a camera was          tagcal pose --camera camera.yaml --target board.yaml photo.jpg\n"
    "  find corners only           tagcal detect --target board.yaml photos/*.jpg --out "
    "corners.csv\n"
    "  remove the distortion       tagcal reproject --camera camera.yaml photo.jpg --undistort all "
    "\\\n"
    "                                --out flat\n"
    "  for other programs          tagcal convert camera.yaml camera.ros.yaml --to ros\n"
    "  compare two calibrations    tagcal diff monday.yaml friday.yaml\n"
    "  check against OpenCV        tagcal validate camera.yaml --dataset desk\n"
    "  try it without a camera     tagcal render scene.yaml --out desk\n\n"
    "tagcal --help lists all commands, tagcal COMMAND --help the options of one.\n";

// CLI11's, with lines of the terminal's text.
class WrappedFormatter : public CLI::Formatter {
 public:
  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    const std::string name =
        "  " + make_option_name(option, is_positional) + make_option_opts(option);
    const std::string indent(column_width_, ' ');
    const bool is_long = name.size() + 2 > column_width_;
    const std::string first = is_long ? name + "\n" + indent : name + indent.substr(name.size());
    return wrapped(first, make_option_desc(option), column_width_);
  }
};

// Help and version are results too: a full disk is no success.
int print_success(const CLI::App& app, const CLI::Success& help_or_version) {
  std::ostringstream text;
  const int code = app.exit(help_or_version, text);
  try {
    print_result(text.str());
  } catch (const Error& error) {
    return report(error.what());
  }
  return code;
}

std::string& typed_command() {
  static std::string text;
  return text;
}

// In single quotes, unless no character means anything to a shell.
std::string quoted(const std::string& word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./,:@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

// CLI11 takes the next argument for the value of `--name=`.
void refuse_missing_values(int argc, char** argv) {
  for (int i = 1; i < argc && std::string_view(argv[i]) != "--"; ++i) {
    const std::string_view word = argv[i];
    if (word.starts_with("--") && word.find('=') + 1 == word.size())
      throw Error(fmt::format("{}: must not be empty", word.substr(0, word.size() - 1)));
  }
}

}  // namespace

const std::string& command_as_typed() { return typed_command(); }

int run_command_line(int argc, char** argv, const CommandTable& table) {
  CLI::App app("Camera calibration and poses from pictures of targets, with their uncertainty.",
               "tagcal");
  app.formatter(std::make_shared<WrappedFormatter>());
  app.set_version_flag("--version", "tagcal " TAGCAL_VERSION "\nbuilt with " TAGCAL_BUILT_WITH);
  app.require_subcommand(1, 1);
  app.footer(
      "Example: tagcal render scene.yaml --out desk && tagcal calibrate desk --out camera.yaml\n"
      "Exit codes: 0 an answer, 1 a check that fails, 2 bad input or usage, 3 no answer.");
  end_tidily_on_signals();
  const std::vector<Command> commands = table(app);
  typed_command() = "tagcal";
  for (int i = 1; i < argc; ++i) typed_command() += " " + quoted(argv[i]);
  try {
    if (argc == 1) {
      print_result(std::string(kGuide));
      return kAnswer;
    }
    refuse_missing_values(argc, argv);
    app.parse(argc, argv);
    return chosen(commands)->run();
  } catch (const CLI::Success& help_or_version) {
    return print_success(app, help_or_version);
  } catch (const CLI::ParseError& error) {
    return report(usage_error(error, app, commands));
  } catch (const Error& error) {
    return report(error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    return report(fmt::format("{}: {}", error.path1().string(), error.code().message()));
  } catch (const std::bad_alloc&) {
    return report("out of memory");
  } catch (const std::exception& error) {
    return report(error.what());
  }
}

}  // namespace tagcal::tools
