#pragma once

#include <filesystem>
#include <string>

namespace tagcal::tools {

// Returns true if gnuplot is installed.
bool has_gnuplot();

// Runs gnuplot (as a child process, without a shell) on a script; its standard output becomes the
// file. Throws Error with the first line of its error message.
void draw_with_gnuplot(const std::string& script, const std::filesystem::path& file);

}  // namespace tagcal::tools
