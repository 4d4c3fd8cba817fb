#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/io/formats/lens_numbers.hpp"
#include "tagcal/io/types.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"

namespace tagcal::internal {

// A file of cameras before its format is known.
struct CameraText {
  std::filesystem::path path;
  std::string text;
  std::optional<YamlValue> top;  // the keys of YAML, JSON or OpenCV's XML
  ImageSize stated_size;         // of the pictures, if the file has none; 0 x 0: not known
};

// A kind of file of a format, which is recognised by its text or by its keys: one of the two
// functions is null.
struct FormatReader {
  bool (*has_text)(std::string_view text) = nullptr;
  bool (*has_keys)(const YamlValue& top) = nullptr;
  CameraFile (*read)(const CameraText& file) = nullptr;
};

// A format: its description, its readers and its writer.
struct FormatRow {
  CameraFormat format;
  std::string_view key;  // that its files must have, for messages; "": another row names it
  std::array<FormatReader, 2> readers;
  FormatOutput (*write)(const CameraFile& file, const std::filesystem::path& out) = nullptr;
  bool any_unit = false;  // the places may be in other units than metres, or are known to be right
};

// In the order of `convert --help`. If two rows recognise a file by its keys, the later one reads
// it: many formats have keys of OpenCV.
std::span<const FormatRow> format_rows();

// The kind of a file, or null. Reads the keys of a file that is not recognised by its text. Throws
// Error if it is not YAML, JSON or XML either.
const FormatReader* reader_of(CameraText& file);

// Folders with one file a camera (CameraFormat::each): the cameras of a rig in formats whose files
// hold one camera and its place.
// True if a path that is to be written names a folder: one that exists, or a name without ending.
bool names_folder(const std::filesystem::path& out);

// The cameras of all files of a folder that have such a name and are of this format, by the names
// of the files, sorted; no value without such files. Throws Error for files that cannot be read.
std::optional<CameraFile> read_camera_folder(const std::filesystem::path& folder,
                                             const FormatRow& row, const ImageSize& stated);

// A file for each camera. Throws Error for names that are no names of files, or equal, and for a
// folder with the file of another camera, which would be read as one of the rig.
FormatOutput write_camera_folder(const CameraFile& file, const FormatRow& row,
                                 const std::filesystem::path& folder);

}  // namespace tagcal::internal
