#pragma once

#include <filesystem>
#include <string>

namespace tagcal::tools {

// Whether there is a gnuplot to run.
bool has_gnuplot();

// Runs gnuplot (as a child process, without a shell) on a script; what it writes to its standard
// output becomes the file. Throws Error with its first line of complaint.
void draw_with_gnuplot(const std::string& script, const std::filesystem::path& file);

}  // namespace tagcal::tools
