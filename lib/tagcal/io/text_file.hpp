#pragma once

#include <algorithm>
#include <chrono>
#include <deque>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/language.hpp"

// Text files as the commands read and write them: whole, under a lock, and fields of CSV.

namespace tagcal {

// ---- Files

// Reads a whole text file, or a pipe up to its end, without the byte order mark of UTF-8; throws
// Error (missing, a folder, a device, larger than 256 MiB).
std::string read_text(const std::filesystem::path& file);

// Removes the byte order mark that some programs write before UTF-8.
void remove_byte_order_mark(std::string& text);

// The same without binary data, for tables and lists, whose texts go on as names of files.
std::string read_plain_text(const std::filesystem::path& file);

// Throws Error if the text of a file has binary data.
void check_plain_text(std::string_view text, const std::string& file);

// Returns true for a device, a pipe, and the file that stdout or stderr is redirected to: it is
// written to where it stands, not replaced.
bool is_stream(const std::filesystem::path& file);

// Writes a file whole or not at all: into a temporary file beside it, then renamed. Throws Error
// if that fails, and then leaves no file behind. Streams are written to; a pipe that nobody reads
// is an error.
void write_whole(const std::filesystem::path& file, std::string_view content);

// Removes the temporary files of all calls of write_whole that have not returned yet, and lets none
// begin another one: for a program that a signal ends.
void remove_unfinished_files();

// Keeps other processes of tagcal from writing into a folder at the same time. The lock ends with
// the process. File systems without locks have none.
class FolderLock {
 public:
  // Waits up to `patience` while another process holds it.
  FolderLock(const std::filesystem::path& folder, std::chrono::milliseconds patience);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

// ---- Lines of CSV

// Calls f(line, number) for each line of a text, without its end ("\n" or "\r\n"), numbers from 1.
template <typename F>
void for_each_line(std::string_view text, const F& f) {
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    f(line.substr(0, line.size() - (line.ends_with('\r') ? 1 : 0)), number);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

// Returns true for a name that a line of a text file can hold: not empty, and one line.
bool is_image_name(std::string_view image);

// The name of an image as a field of CSV: in double quotes if it has a comma, a double quote or
// outer spaces, or begins as a comment (#). Throws Error unless is_image_name.
std::string image_field(const std::string& image);

// Any text of one line as a field of CSV, in the same way.
std::string csv_field(std::string_view text);

// The fields of lines of CSV, without the blanks around them. A field may be in double quotes, with
// "" for a double quote.
class CsvFields {
 public:
  // Replaces the fields by those of a line, and returns what is wrong with it; "" if nothing is.
  std::string_view split(std::string_view line);

  // Valid as long as the line, and until the next call of split.
  const std::vector<std::string_view>& fields() const { return fields_; }

 private:
  std::vector<std::string_view> fields_;
  std::deque<std::string> unquoted_;
};

// The text without blanks at both ends: spaces and tabs, unless others are given.
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t");

}  // namespace tagcal
