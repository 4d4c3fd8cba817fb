#include "tagcal/io/yaml/yaml_boards.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>

namespace tagcal::internal {
namespace {

constexpr double kFieldTagSizeM =
    0.1651;                              // 6.5 inches, the black square of FIRST's tags since 2024
constexpr double kUnitTolerance = 1e-3;  // of a quaternion's length

Eigen::Vector3d read_translation(const YamlValue& value) {
  value.allow_only({"x", "y", "z"});
  return {value.at("x").number(), value.at("y").number(), value.at("z").number()};
}

Eigen::Quaterniond read_quaternion(const YamlValue& value) {
  value.allow_only({"W", "X", "Y", "Z"});
  const Eigen::Quaterniond q(value.at("W").number(), value.at("X").number(), value.at("Y").number(),
                             value.at("Z").number());
  if (!(std::abs(q.norm() - 1) < kUnitTolerance))
    value.fail_plainly(fmt::format("must have length 1, got {:.6g}", q.norm()));
  return q.normalized();
}

// Our tag frame, x right, y up, z out of the tag, in WPILib's, x out of the tag, z up.
Eigen::Quaterniond field_tag_from_tag() {
  Eigen::Matrix3d axes;
  axes << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return Eigen::Quaterniond(axes);
}

Tag read_tag(const YamlValue& item, double size, std::set<int>& ids) {
  item.allow_only({"ID", "pose"});
  Tag tag;
  const YamlValue id = item.at("ID");
  tag.id = id.whole(0, std::numeric_limits<int>::max());
  if (!ids.insert(tag.id).second) id.fail("must differ from the ids before it");
  tag.size = size;
  const YamlValue pose = item.at("pose");
  pose.allow_only({"translation", "rotation"});
  const YamlValue rotation = pose.at("rotation");
  rotation.allow_only({"quaternion"});
  tag.board_from_tag = {read_quaternion(rotation.at("quaternion")) * field_tag_from_tag(),
                        read_translation(pose.at("translation"))};
  return tag;
}

void shift_ids(const YamlValue& top, int first_id, const std::set<int>& ids,
               std::vector<Tag>& tags) {
  const std::int64_t shift = std::int64_t{first_id} - *ids.begin();
  if (*ids.rbegin() + shift > std::numeric_limits<int>::max())
    top.fail_plainly(fmt::format("first_id: the ids must stay below 2^31, but end at {}",
                                 *ids.rbegin() + shift));
  for (Tag& tag : tags) tag.id = static_cast<int>(tag.id + shift);
}

}  // namespace

bool is_field_layout(const YamlValue& top) {
  return top.find("tags") && top.find("field") && !top.find("target_type");
}

Board read_field_layout(const YamlValue& top, std::optional<int> first_id,
                        std::optional<double> tag_size_m, std::vector<std::string>* warnings) {
  std::vector<std::string> notes = top.unknown_keys({"tags", "field"});
  const YamlValue field = top.at("field");
  field.allow_only({"length", "width"});
  field.at("length").positive();
  field.at("width").positive();
  Tags board;
  std::set<int> ids;
  for (const YamlValue& item : top.at("tags").items(1, kMaxBoardParts))
    board.tags.push_back(read_tag(item, tag_size_m.value_or(kFieldTagSizeM), ids));
  if (first_id) shift_ids(top, *first_id, ids, board.tags);
  if (!tag_size_m)
    notes.push_back(
        fmt::format("{}: a field layout does not state the size of its tags: {} m is taken (6.5 "
                    "inches, tag36h11 "
                    "with border_bits 1, as FIRST prints them since 2024)",
                    top.file(), kFieldTagSizeM));
  if (warnings) warnings->insert(warnings->end(), notes.begin(), notes.end());
  return {std::move(board), {}};
}

}  // namespace tagcal::internal
