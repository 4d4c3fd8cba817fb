#include "job/messages.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <set>

#include "job/terminal.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

bool& quiet_now() {
  static bool quiet = false;
  return quiet;
}

std::optional<Record>& record_now() {
  static std::optional<Record> record;
  return record;
}

std::vector<std::string>& held_notes() {
  static std::vector<std::string> notes;
  return notes;
}

}  // namespace

std::FILE* message_stream() {
  static std::FILE* const stream = stderr;
  return stream;
}

void set_quiet(bool quiet) { quiet_now() = quiet; }
bool is_quiet() { return quiet_now(); }

void begin_record() { record_now().emplace(); }
const Record& record() { return *record_now(); }

void hold_note(std::string note) { held_notes().push_back(std::move(note)); }
void drop_notes() { held_notes().clear(); }

void release_notes() {
  const std::vector<std::string> notes = std::exchange(held_notes(), {});
  std::set<std::string_view> said;  // once each
  for (const std::string& note : notes)
    if (said.insert(note).second) write_message(note + "\n");
}

void write_message(std::string_view text) {
  release_notes();
  if (record_now()) record_now()->messages.emplace_back(trimmed(text, "\n"));
  const std::optional<std::size_t> columns = columns_of_stream(STDERR_FILENO);
  const std::string plain = without_controls(columns ? fitted(text, *columns) : text);
  std::fwrite(plain.data(), 1, plain.size(), message_stream());
}

void print_result(const std::string& result) {
  release_notes();
  const std::string text = isatty(STDOUT_FILENO) == 1 ? without_controls(result) : result;
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0)
    throw Error(std::string("standard output: cannot be written: ") + std::strerror(errno));
}

void print_text(const std::string& text) {
  if (record_now())
    record_now()->messages.emplace_back(trimmed(without_colours(text), "\n"));
  else
    print_result(columns_of_stream(STDOUT_FILENO) ? fitted(text, text_columns()) : text);
}

void print_summary(const std::string& text, const std::filesystem::path& out) {
  if (is_quiet()) return;
  if (!out.empty() && !is_stream(out)) return print_text(text);
  print_to_stderr("{}", without_colours(text));
}

void print_answer(const std::string& answer, bool is_json, const std::filesystem::path& out) {
  if (is_quiet() && !is_json && !out.empty()) return;
  if (is_stream(out)) return print_to_stderr("{}", without_colours(answer));
  return is_json ? print_result(answer) : print_text(answer);
}

void write_table(const std::string& csv, const std::filesystem::path& out, bool is_json) {
  if (is_json && (out.empty() || is_stream(out))) return;
  if (out.empty()) return print_result(csv);
  write_whole(out, csv);
  say_wrote(out);
}

void say_wrote(const std::filesystem::path& file, const std::string& content) {
  std::error_code unknown;
  if (!std::filesystem::exists(file, unknown) || is_stream(file)) return;
  if (record_now())
    record_now()->files.emplace_back(file.string(), content);
  else
    print_note("wrote {}{}{}\n", file.string(), content.empty() ? "" : ": ", content);
}

void write_answer_file(const std::filesystem::path& file, const std::string& text) {
  if (file.empty()) return;
  write_whole(file, text);
  say_wrote(file);
}

void say_no_answer_file(const std::filesystem::path& file, const char* what) {
  if (!file.empty())
    print_to_stderr("tagcal: {}: not {}, there is no answer\n", file.string(), what);
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
