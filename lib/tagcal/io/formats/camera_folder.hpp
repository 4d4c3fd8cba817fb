#pragma once

#include <filesystem>
#include <vector>

#include "tagcal/io/formats/format_table.hpp"

// Folders with one file a camera (CameraFormat::each): the cameras of a rig in formats whose files
// hold one camera and its place.

namespace tagcal::internal {

// True if a path that is to be written names a folder: one that exists, or a name without ending.
bool names_folder(const std::filesystem::path& out);

// The cameras of all files of a folder that have such a name and are of this format, by the names
// of the files, sorted; no value if there is none. Throws Error for files that cannot be read.
std::optional<CameraFile> read_camera_folder(const std::filesystem::path& folder,
                                             const FormatRow& row, const ImageSize& stated);

// A file for each camera. Throws Error for names that are no names of files, or equal, and for a
// folder with the file of another camera, which would be read as one of the rig.
FormatOutput write_camera_folder(const CameraFile& file, const FormatRow& row,
                                 const std::filesystem::path& folder);

}  // namespace tagcal::internal
