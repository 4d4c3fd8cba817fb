#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace tagcal::internal {

// Reads a whole text file; throws Error (missing, a folder, larger than 256 MiB).
std::string read_text(const std::filesystem::path& file);

// Writes a file whole or not at all: into a temporary file beside it, then renamed. Throws Error
// if that fails, and then leaves no file behind.
void write_whole(const std::filesystem::path& file, std::string_view content);

}  // namespace tagcal::internal
