#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/io/yaml/yaml_reader.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// A target (docs/formats.md), as read_target.
Board board_from_yaml(const YamlValue& top, std::optional<int> first_id,
                      std::vector<std::string>* warnings);
std::string board_yaml(const Board& board);

// One of the boards of a data set or a scene: {file, first_id, world_from_board}. A scene may have
// `target`, a target itself, instead of `file`, and `frame` and `pose`, which are left to the
// caller.
PlacedBoard read_placed_board(const YamlValue& value, bool is_scene,
                              std::vector<std::string>* warnings);

// Throws if two boards have the same id.
void check_unique_ids(const std::vector<PlacedBoard>& boards, const YamlValue& where);

}  // namespace tagcal::internal
