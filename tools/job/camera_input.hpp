#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/io/types.hpp"
#include "tagcal/uncertainty/uncertain_camera.hpp"

namespace tagcal::tools {

// The camera of an option, "FILE" or "FILE:NAME" of any format (docs/tasks/convert.md). What
// reading changed or dropped is a note (hold_note). Throws Error for a lens that only `tagcal
// convert` takes.
CalibrationFile read_camera(const std::string& file_and_name);

// Holds the notes of a conversion of `name`.
void hold_notes(const std::string& name, const std::vector<std::string>& notes);

// A camera of a file with its uncertainty, and the pose of one of its views.
struct LensInput {
  UncertainCamera camera;                 // without a model if the file has no covariance
  std::optional<Pose> camera_from_world;  // of the view
  std::string uncertainty;                // a sentence: where the covariance comes from, or that
                                          // there is none
};

// `view`: the name of a picture in the file, or "".
LensInput read_lens(const std::string& file, const std::string& view);

// camera_from_world of a picture in a camera file. Throws Error for an unknown name.
Pose pose_of_view(const std::string& file, const std::string& name);

}  // namespace tagcal::tools
