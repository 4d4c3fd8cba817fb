#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

// Manual pages and completion, made from the same descriptions as --help.

namespace tagcal::tools {

// What is typed after "tagcal COMMAND": an option or a positional argument.
struct ManualOption {
  std::vector<std::string> names;  // "--out", "-h"; of a positional argument its name
  std::string value;               // what --help shows behind the name; "" of a flag
  std::string description;
  std::vector<std::string> values;  // all that are allowed; empty: any
  bool is_positional = false;
};

struct ManualCommand {
  std::string name, description, footer;
  std::vector<ManualOption> options;
};

// All commands of the program in the order of --help.
std::vector<ManualCommand> manual_commands(const CLI::App& app);

// Pages in the format of man(7): "tagcal.1", and one for each command, "tagcal-calibrate.1".
std::string man_page(const std::vector<ManualCommand>& commands);
std::string man_page(const ManualCommand& command);

// The script that completes commands, options, their values and files in "bash", "zsh" or "fish".
std::string completion(const std::vector<ManualCommand>& commands, const std::string& shell);

// Writes all pages and scripts below a folder `share`, where Debian's man, bash-completion, zsh and
// fish look for them: man/man1, bash-completion/completions, zsh/site-functions,
// fish/vendor_completions.d.
void write_manual(const std::filesystem::path& share, const std::vector<ManualCommand>& commands);

}  // namespace tagcal::tools
