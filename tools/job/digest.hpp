#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace tagcal::tools {

// A number of 64 bits that differs between different contents, and the number of their bytes, as
// text.
std::string digest_of(std::string_view text);

// The same of a file's bytes; "" if it cannot be read, or is no regular file. Of a frame of a
// sequence (sequence_file.hpp) its number and the name, size and time of change of the sequence's
// files: they are too long to read for each frame.
std::string digest_of_file(const std::filesystem::path& file);

}  // namespace tagcal::tools
