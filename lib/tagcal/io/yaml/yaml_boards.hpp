#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/io/yaml/yaml_reader.hpp"
#include "tagcal/scene/board.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// A target (docs/reference/formats.md), as read_target.
Board board_from_yaml(const YamlValue& top, std::optional<int> first_id,
                      std::vector<std::string>* warnings, std::optional<double> tag_size_m = {});
std::string board_yaml(const Board& board);

// True if a file is a field layout of WPILib (AprilTagFieldLayout of the FIRST Robotics
// Competition): JSON with the lists `tags` and `field`, and no `target_type`.
bool is_field_layout(const YamlValue& top);

// The tags of a field layout, in the field's frame: x along the field, z up, metres. WPILib's tag
// frame has x out of the tag and z up. The file names neither the size of the tags nor their
// family: they are tag36h11 and, without `tag_size_m`, 0.1651 m; a warning says so. `first_id`, if
// given, replaces the smallest id, and shifts the others. Throws Error.
Board read_field_layout(const YamlValue& top, std::optional<int> first_id,
                        std::optional<double> tag_size_m, std::vector<std::string>* warnings);

// The target files that the boards of a data set or a scene name: each is read once, however often
// it is named.
class TargetFiles {
 public:
  const YamlValue& read(const std::filesystem::path& file);
  std::vector<std::filesystem::path> names() const;

 private:
  std::map<std::filesystem::path, YamlValue> files_;
};

// One of the boards of a data set or a scene: {file, first_id, world_from_board}. A scene may have
// `target`, a target itself, instead of `file`, and `frame` and `pose`, which are left to the
// caller.
PlacedBoard read_placed_board(const YamlValue& value, bool is_scene, TargetFiles& targets,
                              std::vector<std::string>* warnings);

// Adds the board's tags, corners or points to their number. Throws if all boards together have more
// than one may have: a short file can name a large board many times.
void count_parts(const Board& board, const YamlValue& where, std::size_t& num_parts);

// Throws if two boards have a corner of the same id (target_points), or a tag or marker of the same
// family and id.
void check_unique_ids(const std::vector<PlacedBoard>& boards, const YamlValue& where);

}  // namespace tagcal::internal
