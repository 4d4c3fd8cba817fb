#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "job/calibration_job.hpp"

namespace tagcal::tools {

// Every count-th of the data sets in the order of their names, from the index-th on (1 to count).
struct Chunk {
  std::size_t index = 1;
  std::size_t count = 1;
};

// "37/100". Throws Error.
Chunk chunk_of_text(const std::string& text);

struct ManyOutput {
  std::filesystem::path folder;  // for a calibration file and a summary each; "" writes none
  bool json = false;             // an array instead of a table
  bool resume = false;           // takes over the outcomes of earlier runs; others may run beside
  std::string options;           // that decide the answers, as text
  Chunk chunk = {};
};

// The path of a folder, absolute and without a slash at its end.
std::filesystem::path folder_path(const std::string& folder);

// The name of a camera whose pictures or data set are in a folder: the last part of its path.
std::string camera_name(const std::string& folder);

// Calibrates every folder of job.input.inputs by itself, job.threads of them side by side, one
// thread each, and prints one line for each. An error in one data set is reported in its line and
// does not stop the others. Returns the worst exit code: bad input, no answer, an answer. Throws
// Error before any work for names that are not unique, a folder that cannot be written, and with
// `resume` one whose outcomes were made with other options.
int calibrate_many(const CalibrationJob& job, const ManyOutput& output);

}  // namespace tagcal::tools
