#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tagcal/io/yaml/yaml_reader.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

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
