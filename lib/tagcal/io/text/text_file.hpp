#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace tagcal::internal {

// Reads a whole text file, or a pipe up to its end; throws Error (missing, a folder, a device,
// larger than 256 MiB).
std::string read_text(const std::filesystem::path& file);

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

}  // namespace tagcal::internal
