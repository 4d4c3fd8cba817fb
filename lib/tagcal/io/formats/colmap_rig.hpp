#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/io/formats/lens_numbers.hpp"

// Rigs as COLMAP 3.12 and later have them: rigs.txt, frames.txt.

namespace tagcal::internal {

// The cameras in the frame of a reference, as COLMAP has rigs: that of the file, or the first one.
// No value unless there are several cameras with places.
struct ColmapRig {
  std::size_t reference = 0;
  bool is_reference_frame = false;  // the rig's frame in the file is that of the reference
  std::vector<Pose> camera_from_rig;
};
std::optional<ColmapRig> colmap_rig(const CameraFile& file);

// A sentence if the frame of the rig is another one in COLMAP.
void note_reference(const CameraFile& file, const ColmapRig& rig, std::vector<std::string>& notes);

std::string colmap_pose(const Pose& pose);  // "QW QX QY QZ TX TY TZ"

// rigs.txt: RIG_ID NUM_SENSORS, type and id of the reference, then type, id, HAS_POSE and pose of
// each other sensor.
std::string colmap_rigs_text(const CameraFile& file, const ColmapRig& rig);

// frames.txt, without which COLMAP does not read pictures beside rigs.txt.
std::string colmap_frames_text(const CameraFile& file, const ColmapRig& rig);

}  // namespace tagcal::internal
