#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "job/arguments.hpp"
#include "job/picture_files.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/scene/rig.hpp"

namespace tagcal::tools {

// The input arguments of a command: `DATASET`, or `--target T.yaml IMAGE...`, and optionally a file
// with observations.
struct InputArguments {
  std::string target;                 // a target file; "" for a data set
  double tag_size_m = 0;              // of a target file without one; 0: its default
  std::string family;                 // of tags without a target; `detect` and `pose`
  std::vector<std::string> inputs;    // one folder, or pictures
  std::string observations;           // a CSV file that replaces those of the data set
  std::string refinement;             // of corners in pictures; "": the default
  std::vector<std::string> excluded;  // names or patterns of pictures (picture_files.hpp)
  std::string frames;                 // of videos and bags: as frame_choice takes them
  std::string default_frames;         // the command's own choice, if the user makes none
  bool strict = false;                // a picture that cannot be read ends the run
  bool takes_pictures = false;        // the command has --target, too
  bool no_cache = false;
  std::string out;  // the command's answer: the corner cache stands beside it; "": none
  std::vector<std::string> other_outputs;
};

// `DATASET` or `IMAGE...`, `--target`, `--tag-size`, `--refinement`, `--exclude` and `--strict`.
void add_input(CLI::App& command, InputArguments& arguments);
// Those of the pictures only: all but the first two.
void add_picture_options(CLI::App& command, InputArguments& arguments);
void add_no_cache(CLI::App& command, bool& no_cache);
void add_observations(CLI::App& command, InputArguments& arguments);

struct Input {
  std::string name;          // in messages
  std::string sized_by;      // the data set or picture that has the image size
  Dataset dataset;           // with views if there are observations
  std::string observations;  // the file of the views; "": none
  bool of_dataset = false;   // which dataset.yaml names
  std::vector<ImageSource> images;
  std::map<std::string, std::filesystem::path> files;  // of the images, by name
  // Of frames of videos and bags, and of views whose observations have times, by the image's name:
  // Unix times of bags (ImageSequence::start_s), of videos from the first frame on. Ascending with
  // the images of one sequence.
  std::map<std::string, double> times_s;
  std::optional<FrameTally> frames;          // of one video or bag with --frames auto
  std::vector<std::filesystem::path> texts;  // all other files that were read
  bool strict = false;
  std::filesystem::path cache;           // file of corners found before; "": none
  std::optional<Refinement> refinement;  // of corners that are found; no value: the default
  std::vector<std::vector<UnfittedTag>> unfitted;  // of each view, if detected
  double corner_error_px = 0;                      // as in DetectedPicture
  std::vector<TargetMistake> mistakes;             // that the pictures show
  std::vector<std::string> warnings;
};

// Reads boards, observations, truth, and the headers of the pictures. A picture that cannot be read
// is left out with a warning, or throws Error if that is not allowed. Throws Error if the pictures
// do not have one common size, or none is left, and if an output would replace a file that is read
// or another output. Warns of patterns of --exclude that leave out nothing, but not of those of
// several inputs, to which an exclusion is given.
Input read_input(const InputArguments& arguments, Exclusion* of_several = nullptr);

// --refinement; no value: not given.
std::optional<Refinement> refinement_of(const InputArguments& arguments);

// Makes warnings of the messages about pictures that cannot be read, or throws Error if that is not
// allowed or none is left.
void leave_out(const std::vector<std::string>& unreadable, bool strict, bool none_left,
               std::vector<std::string>& warnings);
void warn_of_unused(const Exclusion& exclusion, std::vector<std::string>& warnings);

// Throws Error for --frames and --tag-size, which the pictures of a data set do not take.
void check_dataset_options(const InputArguments& arguments);

// The time of a picture or view by its name (Input::times_s), if it has one.
std::optional<double> time_of(const Input& input, const std::string& image);

// Keeps the pictures and views of these names only (--view). Throws Error for one that there is
// not.
void choose_views(Input& input, const std::vector<std::string>& names);

// The input of pictures that were read before, with their boards.
Input input_of(const std::string& name, const Dataset& dataset,
               const std::vector<std::filesystem::path>& pictures);

// The file of corners that stands beside a command's answer; "" for a device or a pipe.
std::filesystem::path corner_cache_of(const std::filesystem::path& out);

// Throws Error if a camera, read from `file`, has another image size than the pictures.
void check_image_size(const ImageSize& size, const std::string& file, const Input& input);

// Throws Error if two cameras have pictures with the same corners: one camera was given twice.
// Equal views have equal first pixels.
void check_different(const RigDataset& rig);

// Leaves out the pictures that turned out to be damaged, as read_input does: `unreadable` says for
// each picture why, or "".
void leave_out_unreadable(Input& input, const std::vector<std::string>& unreadable);

void print_warnings(const std::vector<std::string>& warnings);  // to stderr

}  // namespace tagcal::tools
