#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/io/yaml/yaml_reader.hpp"
#include "tagcal/scene/board.hpp"

namespace tagcal::internal {

// A target (docs/reference/formats.md), as read_target.
Board board_from_yaml(const YamlValue& top, std::optional<int> first_id,
                      std::vector<std::string>* warnings, std::optional<double> tag_size_m = {});
std::string board_yaml(const Board& board);

}  // namespace tagcal::internal
