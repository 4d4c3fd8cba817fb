#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/scene/board.hpp"

namespace tagcal {

// A target file (docs/reference/formats.md): Kalibr's YAML `target_type: aprilgrid` (tagCols,
// tagRows, tagSize, tagSpacing; further keys: first_id, family, border_bits, corner_squares) and
// `checkerboard` (targetCols, targetRows, rowSpacingMeters, colSpacingMeters; further keys:
// first_id, starts_black) and `circlegrid` (targetCols, targetRows, spacingMeters, asymmetricGrid;
// further keys: diameterMeters, first_id), or `charuco` (a ChArUco board), `tags` (a list of single
// tags) or `points` (a list of points). `first_id`, if given, overrides the file's. Throws Error.
// Unknown keys in Kalibr's files go to `warnings` (may be null), elsewhere they throw. A field
// layout of WPILib (JSON), recognised by its content, is read as `tags` of tag36h11 in the field's
// frame, of `tag_size_m` > 0, or of 0.1651 m and a warning. `tag_size_m` for any other file throws.
Board read_target(const std::filesystem::path& file, std::optional<int> first_id = {},
                  std::vector<std::string>* warnings = nullptr,
                  std::optional<double> tag_size_m = {});

// The warning of a printed board or tag, `what`, that is wider (m) than any: its length may be one
// of millimetres. No value if it is not.
std::optional<std::string> wide_warning(std::string_view what, double width_m);

// The text of a target file.
std::string target_yaml(const Board& board);

void write_target(const std::filesystem::path& file, const Board& board);

}  // namespace tagcal
