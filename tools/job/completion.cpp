#include <fmt/format.h>

#include <algorithm>

#include "job/manual.hpp"

namespace tagcal::tools {
namespace {

// The first clause of a description, without signs that a shell would read.
std::string brief(const std::string& description) {
  std::string text = description.substr(0, description.find_first_of(";:("));
  std::erase_if(
      text, [](char c) { return std::string_view("'\"`$\\[]").find(c) != std::string_view::npos; });
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

std::vector<std::string> long_names(const ManualCommand& command) {
  std::vector<std::string> names;
  for (const ManualOption& option : command.options)
    for (const std::string& name : option.names)
      if (name.starts_with("--")) names.push_back(name);
  return names;
}

std::string names_of(const std::vector<ManualCommand>& commands) {
  std::vector<std::string> names;
  for (const ManualCommand& command : commands) names.push_back(command.name);
  return fmt::format("{}", fmt::join(names, " "));
}

// "calibrate:--model) values ;;" for each option with a list of values.
std::string bash_values(const ManualCommand& command) {
  std::string text;
  for (const ManualOption& option : command.options)
    if (!option.values.empty() && !option.is_positional)
      text += fmt::format("    {}:{}) COMPREPLY=($(compgen -W '{}' -- \"$word\")); return ;;\n",
                          command.name, option.names.front(), fmt::join(option.values, " "));
  return text;
}

std::string bash_completion(const std::vector<ManualCommand>& commands) {
  std::string values, options;
  for (const ManualCommand& command : commands) {
    values += bash_values(command);
    options +=
        fmt::format("    {}) options='{}' ;;\n", command.name, fmt::join(long_names(command), " "));
  }
  return fmt::format(R"(# Completion of tagcal for bash; made by `tagcal completion bash`.
_tagcal() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} options=
  COMPREPLY=()
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W '{} --help --version' -- "$word"))
    return
  fi
  case "${{COMP_WORDS[1]}}:$before" in
{}  esac
  case "${{COMP_WORDS[1]}}" in
{}  esac
  if [[ $word == -* ]]; then COMPREPLY=($(compgen -W "$options" -- "$word")); fi
}}
complete -o default -F _tagcal tagcal
)",
                     names_of(commands), values, options);
}

std::string zsh_option(const ManualOption& option) {
  if (option.is_positional) return "";
  std::string argument;
  if (!option.value.empty())
    argument = option.values.empty() ? ":value:_files"
                                     : fmt::format(":value:({})", fmt::join(option.values, " "));
  return fmt::format(" \\\n        '{}[{}]{}'", option.names.front(), brief(option.description),
                     argument);
}

std::string zsh_completion(const std::vector<ManualCommand>& commands) {
  std::string list, cases;
  for (const ManualCommand& command : commands) {
    list += fmt::format("    '{}:{}'\n", command.name, brief(command.description));
    cases += fmt::format("    {})\n      _arguments", command.name);
    for (const ManualOption& option : command.options) cases += zsh_option(option);
    cases += " \\\n        '*:file:_files' ;;\n";
  }
  return fmt::format(R"(#compdef tagcal
# Completion of tagcal for zsh; made by `tagcal completion zsh`.
_tagcal() {{
  local -a commands=(
{}  )
  if ((CURRENT == 2)); then
    _describe command commands
    return
  fi
  local command=$words[2]
  shift words
  ((CURRENT--))
  case $command in
{}  esac
}}
_tagcal "$@"
)",
                     list, cases);
}

std::string fish_completion(const std::vector<ManualCommand>& commands) {
  std::string text = "# Completion of tagcal for fish; made by `tagcal completion fish`.\n";
  for (const ManualCommand& command : commands) {
    text += fmt::format("complete -c tagcal -n __fish_use_subcommand -f -a {} -d '{}'\n",
                        command.name, brief(command.description));
    for (const ManualOption& option : command.options) {
      if (option.is_positional) continue;
      const std::string& name = option.names.front();
      const bool is_long = name.starts_with("--");
      text += fmt::format("complete -c tagcal -n '__fish_seen_subcommand_from {}' -{} {} -d '{}'",
                          command.name, is_long ? "l" : "s", name.substr(is_long ? 2 : 1),
                          brief(option.description));
      if (!option.value.empty()) text += " -r";
      if (!option.values.empty()) text += fmt::format(" -f -a '{}'", fmt::join(option.values, " "));
      text += "\n";
    }
  }
  return text;
}

}  // namespace

std::string completion(const std::vector<ManualCommand>& commands, const std::string& shell) {
  if (shell == "bash") return bash_completion(commands);
  if (shell == "zsh") return zsh_completion(commands);
  return fish_completion(commands);
}

}  // namespace tagcal::tools
