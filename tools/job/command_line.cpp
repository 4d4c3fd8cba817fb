#include "job/command_line.hpp"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <exception>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "job/arguments.hpp"
#include "job/interruption.hpp"
#include "job/messages.hpp"
#include "job/plain_text.hpp"
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
  drop_notes();
  print_to_stderr("tagcal: {}\n", one_line(message));
  return kBadInput;
}

const Command* chosen(const std::vector<Command>& commands) {
  const auto found = std::find_if(commands.begin(), commands.end(),
                                  [](const Command& c) { return c.arguments->parsed(); });
  return found == commands.end() ? nullptr : &*found;
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

// CLI11's errors about the option or argument of a command, in our words.
std::string sentence_of(const CLI::ParseError& error, const CLI::App& command) {
  const std::string message = error.what();
  const std::string name = message.substr(0, message.find_first_of(": "));
  if (dynamic_cast<const CLI::RequiredError*>(&error)) {
    const CLI::Option* const option = command.get_option_no_throw(name);
    return option == nullptr ? message
                             : fmt::format("needs {}: {}", name, option->get_description());
  }
  if (dynamic_cast<const CLI::ExcludesError*>(&error))
    return fmt::format("{}, {}: only one of the two is possible", name,
                       message.substr(message.rfind(' ') + 1));
  if (!dynamic_cast<const CLI::ArgumentMismatch*>(&error)) return message;
  const CLI::Option* const option = command.get_option_no_throw(name);
  const bool is_flag = option != nullptr && option->get_items_expected_max() == 0;
  if (!is_flag && option != nullptr && option->count() > 1)
    return name + ": takes one value only" +
           (name == "--target" ? ", a data set has several boards (target: [..] in dataset.yaml)"
                               : "");
  return name + (is_flag ? ": takes no value" : ": needs a value");
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
    return fmt::format("{}; see {} {} --help",
                       extra ? unexpected(app, arguments) : sentence_of(error, arguments),
                       app.get_name(), arguments.get_name());
  }
  const std::vector<std::string> extra = app.remaining();
  std::vector<std::string> names;
  for (const Command& command : commands) names.push_back(command.arguments->get_name());
  if (extra.empty()) return fmt::format("needs a command: {}", fmt::join(names, ", "));
  if (extra.front().starts_with('-'))
    return fmt::format("{}: unknown option{}; see {} --help", extra.front(),
                       did_you_mean(extra.front(), option_names(app)), app.get_name());
  return fmt::format("{}: unknown command{}; known: {}", extra.front(),
                     did_you_mean(extra.front(), names), fmt::join(names, ", "));
}

// Help as wide as the terminal, options in groups. Those that are seldom, and notes, are in
// --help-all.
class GroupedFormatter : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override {
    const bool is_all = mode != CLI::AppFormatMode::Normal;
    std::string text =
        wrapped("", app->get_description(), 0) + fitted(make_usage(app, name), text_columns());
    bool is_part = false;
    for (const std::string_view group : kOptionGroups)
      text += group_text(*app, std::string(group), is_all, is_part);
    text += commands_text(*app);
    const std::string footer = app->get_footer();
    const std::size_t notes = std::min(footer.find(kNotesBegin), footer.size());
    if (notes > 0) text += "\n" + footer.substr(0, notes) + "\n";
    is_part = is_part || (!is_all && notes < footer.size());
    if (is_all && notes < footer.size()) text += "\n" + footer.substr(notes + 1) + "\n";
    if (is_part) text += fmt::format("\nmore: {} --help-all\n", name);
    for (const CLI::App* command : commands_of(*app))
      if (is_all) text += "\n\n" + make_help(command, name + " " + command->get_name(), mode);
    return text;
  }

 private:
  static std::vector<const CLI::App*> commands_of(const CLI::App& app) {
    return app.get_subcommands(
        [](const CLI::App* command) { return !command->get_group().empty(); });
  }

  static std::string line(const std::string& name, const std::string& text, std::size_t width) {
    const std::string indent(width, ' ');
    const bool is_long = name.size() + 4 > width;
    const std::string first =
        is_long ? "  " + name + "\n" + indent : "  " + name + indent.substr(name.size() + 2);
    return wrapped(first, text, width);
  }

  // Sets `is_part` if options are missing.
  std::string group_text(const CLI::App& app, const std::string& group, bool is_all,
                         bool& is_part) const {
    const bool has_model = app.get_option_no_throw("--model") != nullptr;
    std::string text;
    for (const CLI::Option* option : app.get_options()) {
      const bool is_seldom = option->get_group() == group + kSeldomSign;
      if (!is_seldom && option->get_group() != group) continue;
      const bool is_help = option == app.get_help_ptr() || option == app.get_help_all_ptr();
      if (is_help && app.get_parent() != nullptr) continue;
      is_part = is_part || (is_seldom && !is_all);
      if (is_seldom && !is_all) continue;
      const bool is_positional = option->get_positional();
      const std::string value = option->get_option_text();
      const bool is_required = option->get_required() && !is_positional;
      text += line(
          option->get_name(is_positional) + (value.empty() || is_positional ? "" : " " + value),
          option->get_description() + (is_required ? " (required)" : ""), column_width_);
    }
    const std::string title = group == "Options" && has_model ? "Model" : group;
    return text.empty() ? "" : "\n" + title + ":\n" + text;
  }

  static std::string commands_text(const CLI::App& app) {
    constexpr std::size_t kWidth = 15;
    std::string text;
    for (const CLI::App* command : commands_of(app))
      text += line(command->get_name(), command->get_description(), kWidth);
    return text.empty() ? "" : "\nCommands:\n" + text;
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

// --quiet for all, and --json for those that only write files.
void add_common_options(const std::vector<Command>& commands, bool& quiet, bool& json) {
  for (const Command& command : commands) {
    add_flag(*command.arguments, "--quiet", quiet,
             "no progress, no \"wrote FILE\", and no summary of what is in a file")
        .seldom();
    if (command.only_writes)
      add_flag(*command.arguments, "--json", json,
               "what was written and said, as one JSON object on stdout")
          .seldom();
  }
}

void add_program_help(CLI::App& app, const ProgramText& program) {
  const auto formatter = std::make_shared<GroupedFormatter>();
  formatter->column_width(26);
  formatter->label("SUBCOMMAND", "COMMAND");
  app.formatter(formatter);
  app.set_help_flag("-h,--help", "this text; of a command, its options");
  app.set_help_all_flag("--help-all", "all options of all commands");
  app.set_version_flag("--version", "tagcal " TAGCAL_VERSION "\nbuilt with " TAGCAL_BUILT_WITH,
                       "the version of the program and of its libraries");
  app.require_subcommand(1, 1);
  app.footer(program.examples +
             "\nExit codes: 0 an answer, 1 a check that fails, 2 bad input or usage, 3 no answer");
}

int run_in_json(const Command& command) {
  begin_record();
  const int code = command.run();
  release_notes();
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  for (const auto& [file, content] : record().files)
    files.push_back({{"file", file}, {"content", content}});
  print_result(json_text(
      {{"exit_code", code}, {"wrote", std::move(files)}, {"messages", record().messages}}));
  return code;
}

}  // namespace

const std::string& command_as_typed() { return typed_command(); }

void read_help_word(int argc, char** argv) {
  static char help[] = "--help";
  if (argc < 2 || std::string_view(argv[1]) != "help") return;
  if (argc > 2) argv[1] = argv[2];
  argv[argc > 2 ? 2 : 1] = help;
}

int run_command_line(int argc, char** argv, const CommandTable& table, const ProgramText& program) {
  read_help_word(argc, argv);
  CLI::App app(program.description, std::filesystem::path(argv[0]).filename().string());
  add_program_help(app, program);
  end_tidily_on_signals();
  const std::vector<Command> commands = table(app);
  bool quiet = false, json = false;
  add_common_options(commands, quiet, json);
  typed_command() = "tagcal";
  for (int i = 1; i < argc; ++i) typed_command() += " " + quoted(argv[i]);
  try {
    if (argc == 1 && !program.guide.empty()) {
      print_result(program.guide);
      return kAnswer;
    }
    refuse_missing_values(argc, argv);
    app.parse(argc, argv);
    set_quiet(quiet);
    const int code = json ? run_in_json(*chosen(commands)) : chosen(commands)->run();
    release_notes();
    return code;
  } catch (const CLI::Success& help_or_version) {
    if (chosen(commands) == nullptr && !app.remaining().empty())  // "help calibrat"
      return report(usage_error(CLI::ExtrasError(app.remaining()), app, commands));
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
