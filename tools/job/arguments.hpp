#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

// The options library behind a few functions: its headers are parsed by arguments.cpp and
// command_line.cpp only (2 s of compile time for each file that includes them).
namespace tagcal::tools {

inline constexpr const char* kStdout = "/dev/stdout";  // what "-" is where a text is written

// An option or a positional argument that was added to a command.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option& text(const std::string& text);  // what --help shows behind the name
  Option& required();
  Option& excludes(const Option& other);
  Option& one_of(std::vector<std::string> values);
  Option& suggests(const std::vector<std::string>& values);  // to a shell; others are possible
  Option& writes_text();                 // "-" is stdout; an option --out without this refuses it
  Option& reads_text();                  // "-" is stdin
  Option& seldom();                      // only --help-all shows it
  Option& separated_by(char separator);  // and blanks
  Option& repeatable();                  // one value each time
  Option& description(const std::string& text);

 private:
  CLI::Option* option_;
};

CLI::App* add_command(CLI::App& app, const std::string& name, const std::string& description);

// Examples at the end of --help, and notes below them that only --help-all shows.
void add_footer(CLI::App& command, const std::string& examples, const std::string& notes = "");
inline constexpr char kNotesBegin = '\f';

// The groups of --help in their order. An option is in the same one in every command, by its name.
inline constexpr std::string_view kOptionGroups[] = {"Input", "Options", "Output", "Speed"};
inline constexpr char kSeldomSign = '+';  // at the end of the group of an option that is seldom

// " (did you mean X?)": the nearest of the known words, if one or two letters are wrong.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& known);

Option add_option(CLI::App& command, const std::string& name, std::string& value,
                  const std::string& help);
Option add_option(CLI::App& command, const std::string& name, std::vector<std::string>& values,
                  const std::string& help);
Option add_option(CLI::App& command, const std::string& name, std::uint64_t& value,
                  const std::string& help);
Option add_flag(CLI::App& command, const std::string& name, bool& value, const std::string& help);

// The options that were given, with their values, in the order in which the command lists them and
// without the excluded ones.
std::string given_options(const CLI::App& command, const std::vector<std::string>& excluded);

// Options with a number. Their error messages state the allowed range (those of CLI11 print the
// bounds in full, with 309 digits).
Option add_integer(CLI::App& command, const std::string& name, int& value, int minimum,
                   const std::string& help);
Option add_positive(CLI::App& command, const std::string& name, double& value,
                    const std::string& help);

// The same for a length in metres, which may have its unit: 30mm, 3cm, 0.03m, 1in.
Option add_length(CLI::App& command, const std::string& name, double& metres,
                  const std::string& help);

// "f, f+c, ..": the models that one lens can have, for --model. (`weak` has a scale of its own in
// each view.)
std::vector<std::string> model_names();

// "fit, edges or stock"
std::string alternatives(const std::vector<std::string>& words);

// --family, a family of tags or a dictionary.
Option add_family(CLI::App& command, std::string& family, const std::string& description);

// --threads; 0: one per core.
Option add_threads(CLI::App& command, int& threads);

// A goal of the sd of the projection: "0.1px", "0.1 px" or "0.1"; "": 0, no goal. Throws Error.
double goal_of(const std::string& until);

}  // namespace tagcal::tools
