#pragma once

#include <string>
#include <vector>

#include "report/pose_report.hpp"

// The poses of views as files (docs/tasks/pose.md).
namespace tagcal::tools {

struct PosesAsked {
  bool has_camera = false;   // all views are of one known camera
  bool are_of_tags = false;  // a picture has several
};

// Throws Error if the ending of `out` is none of .csv, .json, .tum and .mcap, if its format cannot
// hold such poses, and as check_text_writable.
void check_pose_file(const std::string& out, const PosesAsked& asked);

// Writes the poses, and says so. A table has a line for each view, two for an ambiguous one, with
// the camera in the target's frame, and empty fields of a view without an answer. Paths (.tum,
// .mcap) have the likelier pose of an ambiguous view. `camera`: a camera's file, or "".
void write_poses(const std::string& out, const std::string& camera,
                 const std::vector<PoseReport>& views);

}  // namespace tagcal::tools
