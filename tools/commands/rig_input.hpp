#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "job/arguments.hpp"
#include "job/input.hpp"
#include "tagcal/io/types.hpp"
#include "tagcal/scene/rig.hpp"

namespace tagcal::tools {

// What the commands read of several cameras on one body.
struct RigInputArguments {
  InputArguments input;              // with the folders of all cameras
  std::vector<std::string> targets;  // boards; of several, the places are unknown
  std::vector<std::string> corners;  // files of observations, one a camera
  std::string pair = "name";
  int threads = 0;
};

// Those of a command that takes the input of one camera or of a rig: --observations names files by
// commas.
RigInputArguments rig_arguments(const InputArguments& input, const std::string& pair, int threads);

// The pictures of one camera, with their corners, and the camera of an option.
struct CameraViews {
  Input input;
  CalibrationFile camera;
};

// What the same commands read of one camera. Prints the warnings of reading. Throws Error, also for
// --pair.
CameraViews read_camera_views(const InputArguments& input, const std::string& camera,
                              const std::string& pair, int threads);

// The data set of a rig, with views, and the files of its pictures.
struct RigInput {
  RigDataset rig;
  std::vector<std::map<std::string, std::filesystem::path>> pictures;  // by camera and View::image
  std::optional<Refinement> refinement;                                // of the corners
  std::vector<TargetMistake> mistakes;                                 // that the pictures show
};

// From a data set with the key rig, or a folder or pattern for each camera. Prints the warnings of
// reading. Throws Error.
RigInput read_rig(const RigInputArguments& arguments);

// The same rig with the neighbours of the frames of its videos or bags, which belong to no instant;
// no value if it has them, or has other pictures.
std::optional<RigInput> with_neighbours(const RigInput& rig, const RigInputArguments& arguments);

// Names of the cameras of folders or patterns: the last part of the paths that differs, without
// what a pattern leaves open.
std::vector<std::string> camera_names(const std::vector<std::string>& inputs);
// The same. Throws Error for fewer than two folders, and for one that is given twice.
std::vector<std::string> names_of_folders(const std::vector<std::string>& folders);

// --pair; `more`: further values.
Option add_pair(CLI::App& command, std::string& pair, const std::string& more = "");

}  // namespace tagcal::tools
