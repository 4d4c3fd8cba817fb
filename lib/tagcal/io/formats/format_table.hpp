#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

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

}  // namespace tagcal::internal
