#include "tagcal/io/yaml/yaml_boards.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {

const YamlValue& TargetFiles::read(const std::filesystem::path& file) {
  const auto known = files_.find(file);
  return known != files_.end() ? known->second
                               : files_.emplace(file, YamlValue::read(file)).first->second;
}

std::vector<std::filesystem::path> TargetFiles::names() const {
  std::vector<std::filesystem::path> names;
  for (const auto& [file, target] : files_) names.push_back(file);
  return names;
}

PlacedBoard read_placed_board(const YamlValue& value, bool is_scene, TargetFiles& targets,
                              std::vector<std::string>* warnings) {
  const bool is_map = value.is_map();
  std::optional<int> first_id;
  Pose world_from_board;
  if (is_map) {
    if (is_scene) {
      value.allow_only({"file", "target", "first_id", "world_from_board", "frame", "pose"});
    } else {
      value.allow_only({"file", "first_id", "world_from_board"});
    }
    const auto id = value.find("first_id");
    if (id) first_id = id->whole(0, std::numeric_limits<int>::max());
    const auto pose = value.find("world_from_board");
    if (pose) world_from_board = read_pose(*pose);
    if (is_scene && value.find("target")) {
      if (value.find("file")) value.fail_plainly("has a file and a target, but needs one of them");
      return {board_from_yaml(value.at("target"), first_id, warnings), world_from_board};
    }
  }
  const YamlValue name = is_map ? value.at("file") : value;
  const std::filesystem::path folder = std::filesystem::path(value.file()).parent_path();
  return {board_from_yaml(targets.read(folder / name.text()), first_id, warnings),
          world_from_board};
}

void count_parts(const Board& board, const YamlValue& where, std::size_t& num_parts) {
  const std::size_t num_tags = tags_of(board).size();
  num_parts += point_kind(board) == PointKind::tag_corner
                   ? num_tags
                   : std::max(num_tags, target_points(board).size());
  if (num_parts > std::size_t{kMaxBoardParts})
    where.fail_plainly(fmt::format(
        "the boards must have at most {} tags, corners and points in all, got {} and more",
        kMaxBoardParts, num_parts));
}

void check_unique_ids(const std::vector<PlacedBoard>& boards, const YamlValue& where) {
  std::map<int, std::size_t> board_of_id;
  std::map<std::pair<std::string, int>, std::size_t> board_of_marker;
  for (std::size_t i = 0; i < boards.size(); ++i) {
    const Board& board = boards[i].board;
    for (const TargetPoint& point : target_points(board)) {
      const auto [place, is_new] = board_of_id.emplace(point.id.tag_id, i);
      if (is_new || place->second == i) continue;
      where.fail_plainly(fmt::format(
          "ids must be unique over all boards, but id {} is on boards {} and {}; give one of "
          "them another first_id",
          point.id.tag_id, place->second, i));
    }
    const auto kind = tag_kind(board);
    for (const Tag& tag : tags_of(board)) {
      const auto [place, is_new] = board_of_marker.emplace(std::pair(kind->family, tag.id), i);
      if (is_new) continue;
      where.fail_plainly(
          fmt::format("markers of {} must be unique over all boards, but marker {} is on boards "
                      "{} and {}; give one of them another first_marker_id",
                      kind->family, tag.id, place->second, i));
    }
  }
}

}  // namespace tagcal::internal
