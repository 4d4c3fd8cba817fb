#include "job/manual.hpp"

#include <fmt/format.h>

#include <CLI/App.hpp>

#include "tagcal/error.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/version.hpp"

namespace tagcal::tools {
namespace {

// The values of a check for membership, which CLI11 describes as {a,b,c}.
std::vector<std::string> allowed_values(const CLI::Option& option) {
  std::vector<std::string> values;
  const std::string type = option.get_type_name();
  const std::size_t begin = type.find('{'), end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos) return values;
  std::string list = type.substr(begin + 1, end - begin - 1) + ",";
  for (std::size_t comma = list.find(','); comma != std::string::npos; comma = list.find(',')) {
    values.push_back(list.substr(0, comma));
    list.erase(0, comma + 1);
  }
  return values;
}

ManualOption manual_option(const CLI::Option& option) {
  ManualOption result{{}, "", option.get_description(), allowed_values(option), false};
  for (const std::string& name : option.get_lnames()) result.names.push_back("--" + name);
  for (const std::string& name : option.get_snames()) result.names.push_back("-" + name);
  result.is_positional = result.names.empty();
  if (result.is_positional) result.names.push_back(option.get_name(true));
  if (option.get_items_expected_max() != 0 && !result.is_positional)
    result.value = option.get_option_text().empty() ? "TEXT" : option.get_option_text();
  return result;
}

// Text in which man's own signs stand for themselves.
std::string roff(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      if ((c == '.' || c == '\'') && (result.empty() || result.back() == '\n')) result += "\\&";
      result += c;
    }
  }
  return result;
}

std::string man_head(const std::string& name, const std::string& description) {
  return fmt::format(".TH {} 1 \"\" \"tagcal {}\" \"tagcal\"\n.SH NAME\n{} \\- {}\n", roff(name),
                     TAGCAL_VERSION, roff(name), roff(description));
}

std::string man_option(const ManualOption& option) {
  std::string names;
  for (const std::string& name : option.names)
    names += fmt::format("{}\\fB{}\\fR", names.empty() ? "" : ", ", roff(name));
  if (!option.value.empty()) names += " \\fI" + roff(option.value) + "\\fR";
  return fmt::format(".TP\n{}\n{}\n", names, roff(option.description));
}

std::string man_examples(const std::string& footer) {
  constexpr std::string_view kWord = "Example: ";
  if (!footer.starts_with(kWord)) return footer.empty() ? "" : ".SH NOTES\n" + roff(footer) + "\n";
  std::string text = footer.substr(kWord.size());
  const std::string indent = "\n" + std::string(kWord.size(), ' ');
  for (std::size_t at = text.find(indent); at != std::string::npos; at = text.find(indent))
    text.replace(at, indent.size(), "\n");
  return ".SH EXAMPLES\n.nf\n" + roff(text) + "\n.fi\n";
}

}  // namespace

std::vector<ManualCommand> manual_commands(const CLI::App& app) {
  std::vector<ManualCommand> commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_group().empty()) continue;  // hidden from --help
    ManualCommand result{
        command->get_name(), command->get_description(), command->get_footer(), {}};
    for (const CLI::Option* option : command->get_options())
      if (!option->get_group().empty()) result.options.push_back(manual_option(*option));
    commands.push_back(std::move(result));
  }
  return commands;
}

std::string man_page(const std::vector<ManualCommand>& commands) {
  std::string text = man_head("tagcal", "camera calibration and poses, with their uncertainty") +
                     ".SH SYNOPSIS\n\\fBtagcal\\fR \\fICOMMAND\\fR ...\n.SH COMMANDS\n";
  for (const ManualCommand& command : commands)
    text += fmt::format(".TP\n\\fBtagcal\\-{}\\fR(1)\n{}\n", roff(command.name),
                        roff(command.description));
  return text +
         ".SH EXIT STATUS\n0: an answer. 1: a check that fails. 2: bad input or usage. 3: no "
         "answer.\n.SH ENVIRONMENT\n\\fBNO_COLOR\\fR: if set, no colours.\n";
}

std::string man_page(const ManualCommand& command) {
  std::string synopsis, options;
  for (const ManualOption& option : command.options) {
    if (option.is_positional) synopsis += " \\fI" + roff(option.names.front()) + "\\fR";
    options += man_option(option);
  }
  return man_head("tagcal-" + command.name, command.description) +
         fmt::format(".SH SYNOPSIS\n\\fBtagcal {}\\fR [OPTIONS]{}\n.SH OPTIONS\n",
                     roff(command.name), synopsis) +
         options + man_examples(command.footer) + ".SH SEE ALSO\n\\fBtagcal\\fR(1)\n";
}

void write_manual(const std::filesystem::path& share, const std::vector<ManualCommand>& commands) {
  const std::filesystem::path man = share / "man/man1";
  const std::filesystem::path bash = share / "bash-completion/completions";
  const std::filesystem::path zsh = share / "zsh/site-functions";
  const std::filesystem::path fish = share / "fish/vendor_completions.d";
  for (const auto& folder : {man, bash, zsh, fish}) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw Error(fmt::format("{}: cannot be made: {}", folder.string(), error.message()));
  }
  write_whole(man / "tagcal.1", man_page(commands));
  for (const ManualCommand& command : commands)
    write_whole(man / ("tagcal-" + command.name + ".1"), man_page(command));
  write_whole(bash / "tagcal", completion(commands, "bash"));
  write_whole(zsh / "_tagcal", completion(commands, "zsh"));
  write_whole(fish / "tagcal.fish", completion(commands, "fish"));
}

}  // namespace tagcal::tools
