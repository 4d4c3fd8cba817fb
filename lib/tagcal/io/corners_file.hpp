#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/detect/types.hpp"
#include "tagcal/scene/dataset.hpp"

// Corners in the files of other programs (docs/tasks/convert.md). read_observations of
// dataset_file.hpp reads all of them.

namespace tagcal {

// Returns true for a list of corners that read_observations reads: tagcal's CSV, mrcal's
// corners.vnl, OpenCV's image_points.
bool is_corners_file(const std::filesystem::path& file);

// The format that the name of a file of corners stands for: ".csv" (tagcal), ".vnl" (mrcal),
// ".yaml", ".yml", ".xml", ".json" (opencv); "" for others.
std::string_view corners_format_of_name(const std::filesystem::path& file);

// Writes corners as "tagcal" (CSV), "mrcal" (vnl) or "opencv" (image_points; XML and JSON by the
// name). The last two need one board that is a checkerboard or points, and list its corners row by
// row from the upper left. Returns what was dropped, a sentence each. Throws Error.
std::vector<std::string> write_corners(const std::filesystem::path& out,
                                       const std::vector<View>& views,
                                       const std::vector<PlacedBoard>& boards,
                                       std::string_view format);

// The corners of tags without a board as a file of observations with one more column: `instance`
// counts the tags of one id in an image, from 0. `tags` has a list for each image. Throws Error for
// a name of an image that is not one line.
std::string tags_csv(const std::vector<std::string>& images,
                     const std::vector<std::vector<DetectedTag>>& tags);

}  // namespace tagcal
