#include "job/arguments.hpp"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "tagcal/camera/model.hpp"
#include "tagcal/io/text/length_text.hpp"

namespace tagcal::tools {
namespace {

template <typename T>
std::optional<T> number_of(const std::string& text) {
  T value{};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

// A script's empty variable is no value, and must not be taken for an option that was left out.
std::string not_empty(const std::string& text) { return text.empty() ? "must not be empty" : ""; }

}  // namespace

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
  option_->check(CLI::IsMember(std::move(values)));
  return *this;
}

Option& Option::separated_by(char separator) {
  option_->delimiter(separator);
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

void add_footer(CLI::App& command, const std::string& text) { command.footer(text); }

Option add_option(CLI::App& command, const std::string& name, std::string& value,
                  const std::string& help) {
  return Option(command.add_option(name, value, help)->check(not_empty, "", ""));
}

Option add_option(CLI::App& command, const std::string& name, std::vector<std::string>& values,
                  const std::string& help) {
  return Option(command.add_option(name, values, help)->check(not_empty, "", ""));
}

Option add_option(CLI::App& command, const std::string& name, std::uint64_t& value,
                  const std::string& help) {
  return Option(command.add_option(name, value, help));
}

Option add_flag(CLI::App& command, const std::string& name, bool& value, const std::string& help) {
  return Option(command.add_flag(name, value, help));
}

Option add_integer(CLI::App& command, const std::string& name, int& value, int minimum,
                   const std::string& help) {
  return Option(command.add_option(name, value, help)
                    ->check(
                        [minimum](const std::string& text) {
                          const std::optional<int> number = number_of<int>(text);
                          if (number && *number >= minimum) return std::string();
                          return fmt::format("must be a whole number, {} or more, got {}", minimum,
                                             text);
                        },
                        "", "")
                    ->option_text("N"));
}

Option add_positive(CLI::App& command, const std::string& name, double& value,
                    const std::string& help) {
  return Option(command.add_option(name, value, help)
                    ->check(
                        [](const std::string& text) {
                          const std::optional<double> number = number_of<double>(text);
                          if (number && std::isfinite(*number) && *number > 0) return std::string();
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
  return Option(command.add_option(name, metres, help)
                    ->transform(CLI::Validator(in_metres, "", ""))
                    ->option_text("LENGTH"));
}

std::string model_names() {
  std::string names;
  for (const Model& model : Model::all())
    if (model.kind().is_central)
      names += fmt::format("{}{}", names.empty() ? "" : ", ", model.name());
  return names;
}

Option add_threads(CLI::App& command, int& threads) {
  return add_integer(command, "--threads", threads, 0,
                     "pictures to process in parallel; 0: one per core");
}

}  // namespace tagcal::tools
