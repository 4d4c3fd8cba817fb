#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/io/types.hpp"

// Cameras in the files of tagcal and of other programs (docs/tasks/convert.md has the formats and
// their conventions). Inside the library all of them mean the same: pixel (0, 0) is the centre of
// the upper left pixel, the camera looks along z with y down, poses are camera_from_world, in
// metres.

namespace tagcal {

// The formats that are read or written.
std::span<const CameraFormat> camera_formats();

// Reads all cameras of a file, whose format is recognised by its content, and the poses of its
// pictures. `file` may also be a folder with COLMAP's cameras.txt or cameras.bin. truth.yaml of a
// data set counts as a file of tagcal. Throws Error, naming file, key and value, also for lenses
// that tagcal cannot represent (`LENSMODEL_CAHVOR`, `omni` with distortion, ..), by their names.
// `stated`: the size of the pictures, for files without one whose numbers depend on it
// (camera_angle_x).
CameraFile read_camera_file(const std::filesystem::path& file, const ImageSize& stated = {});

// The same for one camera, "FILE" or "FILE:NAME"; the name may be left out if there is one camera.
// Both may have colons: FILE is the longest that exists. The result has that camera, and its poses
// only. Throws Error for an unknown name.
CameraFile read_one_camera(const std::string& file_and_name, const ImageSize& stated = {});

// The camera of a file of one camera, for use by tagcal. Throws Error if the lens is one of others,
// or the image size is not in the file.
const CalibrationFile& usable_camera(const CameraFile& file, const std::string& name);

// The poses of `tagcal pose --json`, of the views that have one; the camera is number 0. Throws
// Error.
std::vector<ImagePose> read_poses(const std::filesystem::path& file);

// Returns true if the file is one that read_camera_file recognises; it may still have errors.
// Throws Error if it cannot be read or is not YAML, JSON or XML.
bool is_camera_file(const std::filesystem::path& file);

// The format whose `ending` the name of a file has; "" for others.
std::string_view format_of_name(const std::filesystem::path& file);

// Writes the cameras and poses in a format by name, whole or not at all; colmap writes a folder
// unless the name is cameras.txt. Returns what was changed or dropped, a sentence each. Throws
// Error if the format cannot represent a lens (coefficients that are not zero are never dropped),
// or several cameras.
std::vector<std::string> write_camera_file(const std::filesystem::path& out, const CameraFile& file,
                                           std::string_view format);

// Puts the cameras of a file on other pixels: each becomes the one of `cameras`, which is it after
// `cropped` and `resized` (viewing/viewport.hpp). The parameters of the lens change linearly, and
// all covariances with them, exactly. A model that does not have the new lens (a principal point at
// the centre of the image, fx as fy) becomes one that frees these, with zeros for what was held.
// The region of the corners is cut to the new image; camera_error_px grows by the larger scale.
// Findings stay as they are.
void put_on_pixels(CameraFile& file, std::span<const Camera> cameras);

}  // namespace tagcal
