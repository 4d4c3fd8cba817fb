#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/io/formats/format_table.hpp"

// COLMAP's text: cameras.txt, and images.txt for poses; its rigs and its binary files.

namespace tagcal::internal {

// Returns true if the first line that is no comment begins as one of cameras.txt.
bool is_colmap_cameras(std::string_view text);

// `images`: the text of images.txt, if there is one. The names are those of the files in messages.
struct ColmapText {
  std::string name;
  std::string text;
};
// `rigs`: that of rigs.txt (COLMAP 3.12 and later), which places the cameras.
CameraFile read_colmap(const ColmapText& cameras, const std::optional<ColmapText>& images,
                       const std::optional<ColmapText>& rigs = {});

// cameras.txt, images.txt and an empty points3D.txt, or cameras.txt only; of a rig also rigs.txt,
// frames.txt and rig_config.json.
FormatOutput write_colmap(const CameraFile& file, bool cameras_only);

// A lens by COLMAP's name and PARAMS, with the pixel centres moved. Throws Error, beginning with
// `where`.
Lens colmap_lens(const std::string& name, std::span<const double> values, const std::string& where);

struct ColmapLens {
  std::string_view name;
  std::vector<double> values;
};
ColmapLens lens_of_colmap(const FileCamera& camera);  // throws Error for those of others

// The cameras in the frame of a reference, as COLMAP 3.12 and later have rigs: that of the file, or
// the first one. No value unless there are several cameras with places.
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

// rig_config.json, which `colmap rig_configurator` reads (3.12 and later): cameras by the folders
// of their pictures, their places and lenses, without the sizes of the pictures.
bool is_rig_config(std::string_view text);
CameraFile read_rig_config(const CameraText& config);
std::string rig_config_text(const CameraFile& file, const ColmapRig& rig);
FormatOutput write_rig_config(const CameraFile& file);

// COLMAP's binary files as the text of cameras.txt and images.txt. `file` is the name in messages.
// Throws Error for a truncated file and for a number of a camera model that COLMAP does not have.
std::string colmap_cameras_text(const std::string& bytes, const std::string& file);
std::string colmap_images_text(const std::string& bytes, const std::string& file);

}  // namespace tagcal::internal
