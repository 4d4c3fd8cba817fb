#include "job/messages.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "job/terminal.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {

std::FILE* message_stream() {
  static std::FILE* const stream = stderr;
  return stream;
}

void write_message(std::string_view text) {
  const std::string plain = without_controls(text);
  std::fwrite(plain.data(), 1, plain.size(), message_stream());
}

void print_result(const std::string& result) {
  const std::string text = isatty(STDOUT_FILENO) == 1 ? without_controls(result) : result;
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0)
    throw Error(std::string("standard output: cannot be written: ") + std::strerror(errno));
}

void print_summary(const std::string& text, const std::filesystem::path& out) {
  std::error_code none;
  if (std::filesystem::is_regular_file(out, none) && !is_stream(out)) return print_result(text);
  print_to_stderr("{}", without_colours(text));
}

void say_wrote(const std::filesystem::path& file, const std::string& content) {
  std::error_code unknown;
  if (std::filesystem::exists(file, unknown) && !is_stream(file))
    print_to_stderr("wrote {}{}{}\n", file.string(), content.empty() ? "" : ": ", content);
}

Error named_error(const std::string& name, const Error& error) {
  const std::string message = error.what();
  const bool is_named = message.starts_with("--") || message.starts_with(name + ":");
  return Error(is_named ? message : name + ": " + message);
}

Error option_error(const Error& error) {
  static constexpr std::pair<std::string_view, std::string_view> kOptions[] = {
      {"fixed: ", "--fix: "},
      {"start: ", "--start: "},
      {"model: ", "--model: "},
      {"tolerance_px: ", "--tolerance: "},
      {"board_warp: ", "--board-warp: "}};
  const std::string message = error.what();
  for (const auto& [key, option] : kOptions)
    if (message.starts_with(key)) return Error(std::string(option) + message.substr(key.size()));
  return error;
}

void reserve_standard_streams() {
  message_stream();  // before any other library has its turn
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) != -1) continue;
    // The lowest free number is the stream's: those below it are taken.
    const int opened = open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY);
    if (opened < 0) return;
  }
}

}  // namespace tagcal::tools
