#include "job/arguments.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/App.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "job/plain_text.hpp"
#include "tagcal/camera/model.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

// A script's empty variable is no value, and must not be taken for an option that was left out.
std::string not_empty(const std::string& text) { return text.empty() ? "must not be empty" : ""; }

// CLI11 takes the next option for the value that was forgotten: `--undistort --out new`.
std::string not_option(const std::string& text) {
  return text.size() > 2 && text.starts_with("--") ? "needs a value before " + text : "";
}

std::string not_stdout(const std::string& text) {
  return text == "-" ? "- is standard output, which takes text only: give a name" : "";
}

// Option names by group; all others are of the model, or of what a command does.
constexpr std::string_view kInputs[] = {
    "--target",       "--tag-size",   "--refinement", "--exclude", "--strict",
    "--observations", "--family",     "--dataset",    "--camera",  "--one-camera",
    "--border-bits",  "--view",       "--poses",      "--pair",    "--find-boards",
    "--cameras",      "--image-size", "--units",      "--limits"};
constexpr std::string_view kOutputs[] = {
    "--out",     "--json",     "--draw",   "--report", "--uncertainty", "--verbose",
    "--quiet",   "--explain",  "--advise", "--mask",   "--maps",        "--force",
    "--picture", "--svg",      "--opengl", "--steps",  "--tiles",       "--depth-unit-m",
    "--csv",     "--distance", "--to",     "--dpi"};
constexpr std::string_view kSpeeds[] = {"--threads", "--no-cache", "--resume", "--chunk",
                                        "--every"};

std::string group_of(const std::string& name) {
  if (!name.starts_with('-')) return std::string(kOptionGroups[0]);
  for (const auto& [names, group] : {std::pair(std::span<const std::string_view>(kInputs), 0),
                                     {std::span<const std::string_view>(kOutputs), 2},
                                     {std::span<const std::string_view>(kSpeeds), 3}})
    if (std::ranges::find(names, name) != names.end())
      return std::string(kOptionGroups[static_cast<std::size_t>(group)]);
  return std::string(kOptionGroups[1]);
}

// All options of the commands come through here.
Option in_group(const std::string& name, CLI::Option* option) {
  return Option(option->group(group_of(name)));
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

}  // namespace

std::string alternatives(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 < words.size() ? ", " : " or ") + words[i];
  return text;
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& known) {
  std::size_t least = std::min<std::size_t>(2, word.size() / 2);  // a word of one letter is no typo
  std::vector<std::string> nearest;
  for (const std::string& name : known) {
    const std::size_t distance = edit_distance(word, name);
    if (distance < least) nearest.clear();
    if (distance > least) continue;
    least = distance;
    nearest.push_back(name);
  }
  return nearest.empty() ? "" : fmt::format(" (did you mean {}?)", alternatives(nearest));
}

Option& Option::text(const std::string& text) {
  option_->option_text(text);
  return *this;
}

Option& Option::required() {
  option_->required();
  return *this;
}

Option& Option::excludes(const Option& other) {
  option_->excludes(other.option_);
  return *this;
}

Option& Option::one_of(std::vector<std::string> values) {
  const std::string list = fmt::format("{{{}}}", fmt::join(values, ","));
  const auto is_known = [values = std::move(values)](const std::string& text) {
    if (std::ranges::find(values, text) != values.end()) return std::string();
    return fmt::format("must be {}, got {}{}", alternatives(values), text,
                       did_you_mean(text, values));
  };
  option_->check(is_known, list, "");
  return *this;
}

Option& Option::suggests(const std::vector<std::string>& values) {
  option_->check([](const std::string&) { return std::string(); },
                 fmt::format("{{{}}}", fmt::join(values, ",")), "");
  return *this;
}

namespace {

// "-" is this file.
CLI::Validator dash_is(const std::string& file) {
  const auto named = [file](std::string& text) {
    if (text == "-") text = file;
    return std::string();
  };
  return {named, "", ""};
}

}  // namespace

Option& Option::writes_text() {
  option_->transform(dash_is(kStdout));
  return *this;
}

Option& Option::reads_text() {
  option_->transform(dash_is("/dev/stdin"));
  return *this;
}

Option& Option::seldom() {
  option_->group(option_->get_group() + kSeldomSign);
  return *this;
}

Option& Option::separated_by(char separator) {
  const auto trim = [](std::string& text) {
    text = trimmed(text);
    return std::string();
  };
  option_->delimiter(separator)->transform(CLI::Validator(trim, "", ""));
  return *this;
}

Option& Option::repeatable() {
  option_->allow_extra_args(false)->take_all();
  return *this;
}

Option& Option::description(const std::string& text) {
  option_->description(text);
  return *this;
}

CLI::App* add_command(CLI::App& app, const std::string& name, const std::string& description) {
  return app.add_subcommand(name, description);
}

void add_footer(CLI::App& command, const std::string& examples, const std::string& notes) {
  command.footer(notes.empty() ? examples : examples + kNotesBegin + notes);
}

std::string given_options(const CLI::App& command, const std::vector<std::string>& excluded) {
  std::string text;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_positional() || option->count() == 0 ||
        std::ranges::find(excluded, option->get_name()) != excluded.end())
      continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : " ", option->get_name(),
                        fmt::join(option->results(), " "));
  }
  return text;
}

Option add_option(CLI::App& command, const std::string& name, std::string& value,
                  const std::string& help) {
  CLI::Option* const option = command.add_option(name, value, help)->check(not_empty, "", "");
  if (name.starts_with("--")) option->check(not_option, "", "");
  if (name == "--out") option->check(not_stdout, "", "");
  return in_group(name, option);
}

Option add_option(CLI::App& command, const std::string& name, std::vector<std::string>& values,
                  const std::string& help) {
  CLI::Option* const option = command.add_option(name, values, help)->check(not_empty, "", "");
  if (name.starts_with("--")) option->check(not_option, "", "");
  return in_group(name, option);
}

Option add_option(CLI::App& command, const std::string& name, std::uint64_t& value,
                  const std::string& help) {
  return in_group(name, command.add_option(name, value, help));
}

Option add_flag(CLI::App& command, const std::string& name, bool& value, const std::string& help) {
  return in_group(name, command.add_flag(name, value, help));
}

Option add_integer(CLI::App& command, const std::string& name, int& value, int minimum,
                   const std::string& help) {
  return in_group(name, command.add_option(name, value, help)
                            ->check(
                                [minimum](const std::string& text) {
                                  const std::optional<int> number = number_of<int>(text);
                                  if (number && *number >= minimum) return std::string();
                                  return fmt::format("must be a whole number, {} or more, got {}",
                                                     minimum, text);
                                },
                                "", "")
                            ->option_text("N"));
}

Option add_positive(CLI::App& command, const std::string& name, double& value,
                    const std::string& help) {
  return in_group(name, command.add_option(name, value, help)
                            ->check(
                                [](const std::string& text) {
                                  const std::optional<double> number = number_of<double>(text);
                                  if (number && std::isfinite(*number) && *number > 0)
                                    return std::string();
                                  return fmt::format("must be a finite number > 0, got {}", text);
                                },
                                "", "")
                            ->option_text("X"));
}

Option add_length(CLI::App& command, const std::string& name, double& metres,
                  const std::string& help) {
  const auto in_metres = [](std::string& text) {
    const std::optional<double> length = internal::parse_length(text);
    if (!length || !(*length > 0))
      return fmt::format("must be a length in metres, or with its unit (30mm), got {}", text);
    text = fmt::format("{}", *length);
    return std::string();
  };
  return in_group(name, command.add_option(name, metres, help)
                            ->transform(CLI::Validator(in_metres, "", ""))
                            ->option_text("LENGTH"));
}

std::vector<std::string> model_names() {
  std::vector<std::string> names;
  for (const Model& model : Model::all())
    if (model.kind().is_central) names.emplace_back(model.name());
  return names;
}

Option add_family(CLI::App& command, std::string& family, const std::string& description) {
  std::vector<std::string> names = tag_family_names();
  for (std::string& name : tag_dictionary_names()) names.push_back(std::move(name));
  return add_option(command, "--family", family, description).suggests(names).text("NAME");
}

Option add_threads(CLI::App& command, int& threads) {
  return add_integer(command, "--threads", threads, 0,
                     "pictures to process in parallel; 0: one per core");
}

double goal_of(const std::string& until) {
  if (until.empty()) return 0;
  double value = 0;
  const char* const last = until.data() + until.size();
  const auto [end, error] = std::from_chars(until.data(), last, value);
  const std::string_view unit = trimmed({end, last});
  if (error != std::errc() || !(unit == "px" || unit.empty()) || !(value > 0) ||
      !std::isfinite(value))
    throw Error(fmt::format("--until: must be a length in pixels, such as 0.1px, got {}", until));
  return value;
}

}  // namespace tagcal::tools
