// Field layouts of WPILib as targets.

#include <gtest/gtest.h>

#include "file_fixture.hpp"
#include "tagcal/io/target_file.hpp"

namespace tagcal {
namespace {

// Two tags: one faces +x of the field, the other -y. As WPILib writes them.
const std::string kField = R"({
  "tags": [
    {
      "ID": 1,
      "pose": {
        "translation": {"x": 0.0, "y": 5.5, "z": 1.5},
        "rotation": {"quaternion": {"W": 1.0, "X": 0.0, "Y": 0.0, "Z": 0.0}}
      }
    },
    {
      "ID": 7,
      "pose": {
        "translation": {"x": 3.0, "y": 8.0, "z": 1.25},
        "rotation": {"quaternion": {"W": 0.7071067811865476, "X": 0.0, "Y": 0.0, "Z": -0.7071067811865476}}
      }
    }
  ],
  "field": {"length": 16.54, "width": 8.21}
})";

using FieldLayout = FileTest;

TEST_F(FieldLayout, IsReadAsTagsInTheFieldsFrame) {
  std::vector<std::string> warnings;
  const Board target = read_target(write("field.json", kField), {}, &warnings);
  const auto board = std::get<Tags>(target.pattern);
  EXPECT_EQ(board.family, "tag36h11");
  EXPECT_EQ(board.border_bits, 1);
  ASSERT_EQ(board.tags.size(), 2u);
  EXPECT_EQ(board.tags[1].id, 7);
  EXPECT_EQ(board.tags[0].size, 0.1651);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_HAS(warnings[0], "0.1651 m");
  // Who faces a tag that looks along +x looks along -x: y is to the right, z up.
  const double h = 0.1651 / 2;
  const auto first = tag_corners(board.tags[0]);
  EXPECT_LT((first[0] - Eigen::Vector3d(0, 5.5 - h, 1.5 - h)).norm(), 1e-12);
  EXPECT_LT((first[2] - Eigen::Vector3d(0, 5.5 + h, 1.5 + h)).norm(), 1e-12);
  // One that looks along -y has x to the right.
  const auto second = tag_corners(board.tags[1]);
  EXPECT_LT((second[0] - Eigen::Vector3d(3 - h, 8, 1.25 - h)).norm(), 1e-12);
  EXPECT_LT((second[3] - Eigen::Vector3d(3 - h, 8, 1.25 + h)).norm(), 1e-12);
}

TEST_F(FieldLayout, TakesASizeAndAFirstId) {
  std::vector<std::string> warnings;
  const Board target = read_target(write("field.json", kField), 10, &warnings, 0.2);
  const auto board = std::get<Tags>(target.pattern);
  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(board.tags[0].size, 0.2);
  EXPECT_EQ(board.tags[0].id, 10);
  EXPECT_EQ(board.tags[1].id, 16);
  const fs::path grid = write("grid.yaml",
                              "target_type: aprilgrid\ntagCols: 2\ntagRows: 2\ntagSize: 0.1\n"
                              "tagSpacing: 0.25\n");
  EXPECT_HAS(error_of([&] { read_target(grid, {}, nullptr, 0.2); }), "states the size");
}

TEST_F(FieldLayout, MistakesAreNamedByTheirKey) {
  for (const auto& [from, to, message] : std::vector<BadFile>{
           {"\"ID\": 7", "\"ID\": 1", "tags[1].ID: must differ from the ids before it, got 1"},
           {"\"ID\": 7", "\"ID\": -7", "tags[1].ID: must be"},
           {"\"W\": 1.0", "\"W\": 0.5",
            "tags[0].pose.rotation.quaternion: must have length 1, got 0.5"},
           {"\"x\": 3.0, ", "", "tags[1].pose.translation.x: the key is missing"},
           {"\"z\": 1.5", "\"z\": \"high\"", "tags[0].pose.translation.z: must be a"},
           {"\"length\": 16.54, ", "", "field.length: the key is missing"}}) {
    const std::string found =
        error_of([&] { read_target(write("bad.json", replaced(kField, from, to))); });
    EXPECT_HAS(found, "bad.json: " + message);
  }
}

TEST_F(FieldLayout, IsKeptByWritingATarget) {
  const Board board = read_target(write("field.json", kField));
  write_target(folder_ / "tags.yaml", board);
  const std::vector<Tag> again = tags_of(read_target(folder_ / "tags.yaml"));
  ASSERT_EQ(again.size(), 2u);
  EXPECT_LT(distance_between_m(again[1].board_from_tag, tags_of(board)[1].board_from_tag), 1e-15);
}

}  // namespace
}  // namespace tagcal
