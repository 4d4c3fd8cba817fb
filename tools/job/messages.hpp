#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tagcal/error.hpp"

namespace tagcal::tools {

// The stream of the messages: stderr as it was at the start. Other libraries get another one while
// their messages are dropped (study/peers/quiet_stderr.hpp).
std::FILE* message_stream();

void write_message(std::string_view text);

// --quiet: no progress, no notes, and no summary of a result that is in a file.
void set_quiet(bool quiet);
bool is_quiet();

// What a command said, for --json of those that only write files: results become messages.
struct Record {
  std::vector<std::string> messages;
  std::vector<std::pair<std::string, std::string>> files;  // and what they hold
};
void begin_record();
const Record& record();

// Writes to stderr, without control characters, and as wide as the terminal. A message that cannot
// be written (stderr is closed, or its disk is full) is dropped, because it must not change what a
// command does, nor its exit code.
template <typename... Args>
void print_to_stderr(fmt::format_string<Args...> format, Args&&... args) {
  write_message(fmt::format(format, std::forward<Args>(args)...));
}

// The same for what is good to know, but no warning: nothing with --quiet.
template <typename... Args>
void print_note(fmt::format_string<Args...> format, Args&&... args) {
  if (!is_quiet()) print_to_stderr(format, std::forward<Args>(args)...);
}

// Keeps what reading an input changed or left out until the command writes anything else, or ends.
// An error of another input drops the notes: bad input is one line.
void hold_note(std::string note);
void release_notes();
void drop_notes();

// Writes a result to stdout, to a terminal without control characters; throws Error if it cannot be
// written.
void print_result(const std::string& result);

// The same for a person: on a terminal no line is longer than it is wide.
void print_text(const std::string& text);

// Writes what a result came to: to stdout, if the result itself is in the file `out`; otherwise to
// stderr, without colours. Nothing with --quiet.
void print_summary(const std::string& text, const std::filesystem::path& out);

// Writes an answer, as JSON or for a person, of which a part goes to the file `out`, if that is not
// empty: to stderr if `out` is stdout, and for a person not at all with --quiet.
void print_answer(const std::string& answer, bool is_json, const std::filesystem::path& out = {});

// Writes a table to the file `out`, and says so, or to stdout; with --json only to a file.
void write_table(const std::string& csv, const std::filesystem::path& out, bool is_json);

// "wrote FILE", and what it holds: every command says this of each file and folder that it wrote,
// but for caches. Not of devices and pipes, such as /dev/stdout.
void say_wrote(const std::filesystem::path& file, const std::string& content = "");

// Writes the file of an answer, and says so. "": nothing.
void write_answer_file(const std::filesystem::path& file, const std::string& text);

// Says that the file of an answer was not "written" or "drawn", because there is none. "": nothing.
void say_no_answer_file(const std::filesystem::path& file, const char* what = "written");

// An error of the library about what a file or an option gave, with the name of that before it.
Error named_error(const std::string& name, const Error& error);

// The result of `f`; its errors are named.
template <typename F>
auto naming(const std::string& name, const F& f) {
  try {
    return f();
  } catch (const Error& error) {
    throw named_error(name, error);
  }
}

// An error of the library about one of CalibrateOptions, with the option of the command instead.
Error option_error(const Error& error);

template <typename F>
auto naming_options(const F& f) {
  try {
    return f();
  } catch (const Error& error) {
    throw option_error(error);
  }
}

// Opens a descriptor for each of stdin, stdout and stderr that the caller closed: otherwise the
// next file that is opened gets its number, and messages are written into that file. Writing to a
// closed stdout still fails.
void reserve_standard_streams();

}  // namespace tagcal::tools
