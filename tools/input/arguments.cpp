#include "input/arguments.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

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

}  // namespace

CLI::App* add_command(CLI::App& app, const std::string& name, const std::string& description) {
  return app.add_subcommand(name, description);
}

CLI::Option* add_option(CLI::App& command, const std::string& name, std::string& value,
                        const std::string& help) {
  return command.add_option(name, value, help);
}

CLI::Option* add_option(CLI::App& command, const std::string& name,
                        std::vector<std::string>& values, const std::string& help) {
  return command.add_option(name, values, help);
}

CLI::Option* add_option(CLI::App& command, const std::string& name, std::uint64_t& value,
                        const std::string& help) {
  return command.add_option(name, value, help);
}

CLI::Option* add_flag(CLI::App& command, const std::string& name, bool& value,
                      const std::string& help) {
  return command.add_flag(name, value, help);
}

CLI::Option* add_integer(CLI::App& command, const std::string& name, int& value, int minimum,
                         const std::string& help) {
  return command.add_option(name, value, help)
      ->check(
          [minimum](const std::string& text) {
            const std::optional<int> number = number_of<int>(text);
            if (number && *number >= minimum) return std::string();
            return fmt::format("must be a whole number, {} or more, got {}", minimum, text);
          },
          "", "")
      ->option_text("N");
}

CLI::Option* add_positive(CLI::App& command, const std::string& name, double& value,
                          const std::string& help) {
  return command.add_option(name, value, help)
      ->check(
          [](const std::string& text) {
            const std::optional<double> number = number_of<double>(text);
            if (number && std::isfinite(*number) && *number > 0) return std::string();
            return fmt::format("must be a finite number > 0, got {}", text);
          },
          "", "")
      ->option_text("X");
}

CLI::Option* add_threads(CLI::App& command, int& threads) {
  return add_integer(command, "--threads", threads, 0,
                     "pictures worked on side by side; 0: one per core");
}

}  // namespace tagcal::tools
