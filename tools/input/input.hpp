#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "tagcal/detect/detector.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::tools {

// What a command was given to work on: `DATASET`, or `--target T.yaml IMAGE...`, with observations
// from a file where there are any.
struct InputArguments {
  std::string target;               // a target file; "" for a data set
  std::vector<std::string> inputs;  // one folder, or pictures
  std::string observations;         // a CSV file that stands for those of the data set
  std::string refinement;           // of corners that are found in pictures; "" for the usual one
};

// `DATASET` or `IMAGE...`, `--target` and `--refinement`.
void add_input(CLI::App& command, InputArguments& arguments);
void add_observations(CLI::App& command, InputArguments& arguments);

struct Input {
  std::string name;          // what messages call it
  Dataset dataset;           // with views where there are observations
  std::string observations;  // the file that the views were read from; "" where there is none
  std::vector<ImageSource> images;
  Refinement refinement = DetectOptions().refinement;
  std::vector<std::vector<UnfittedTag>> unfitted;  // of each view, where these were detected
  std::vector<std::string> warnings;
};

// Reads all that is small: boards, observations, truth, and the headers of the pictures. Throws
// Error for pictures that do not have the one size of the camera.
Input read_input(const InputArguments& arguments);

// Throws Error where a camera, read from `file`, is one for other pictures.
void check_image_size(const ImageSize& size, const std::string& file, const Input& input);

// Fills in the views by detection, with progress on stderr; the detector's warnings come along.
// Where the camera is known, tags are fitted under its lens. Throws Error without pictures, and
// without tags that could stand in them.
void detect_views(Input& input, int threads, bool shows_progress = true,
                  const Camera* camera = nullptr);

// Views by detection where no observations were read.
void find_views(Input& input, int threads, bool shows_progress = true,
                const Camera* camera = nullptr);

// The same for a calibration: throws Error for fewer than 12 corners in all.
void need_views(Input& input, int threads, bool shows_progress = true);

// The corners of the views once more, in their pictures, with the lens that is known now; those of
// tags that cannot be fitted stay as they were, and a warning says how many. Throws Error without
// pictures.
void refine_views(Input& input, const Camera& camera, int threads, bool shows_progress = true);

// Throws Error where a file could not be written for a plain reason (a folder of that name, no
// folder to hold it), before any work is done for it.
void check_writable(const std::filesystem::path& file);

int num_corners(const std::vector<View>& views);
int num_tags(const std::vector<View>& views);

void print_warnings(const std::vector<std::string>& warnings);  // to stderr
void print_result(const std::string& text);  // to stdout; throws Error if it cannot

}  // namespace tagcal::tools
