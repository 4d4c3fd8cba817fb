#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "target_file_fixture.hpp"

namespace tagcal {
namespace {

TEST_F(TargetFile, KalibrsGridHasKalibrsDefaults) {
  EXPECT_EQ(tags_of(read(kGrid)).size(), 30U);
  const auto grid = read_kind<AprilGrid>(kGrid);
  EXPECT_EQ(grid.columns, 6);
  EXPECT_EQ(grid.rows, 5);
  EXPECT_EQ(grid.tag_size, 0.088);
  EXPECT_EQ(grid.tag_spacing, 0.3);
  EXPECT_EQ(grid.family, "tag36h11");
  EXPECT_EQ(grid.border_bits, 2);
  EXPECT_TRUE(grid.corner_squares);
  EXPECT_FALSE(read_kind<AprilGrid>(kGrid + "border_bits: 1\n").corner_squares);
  EXPECT_TRUE(
      read_kind<AprilGrid>(kGrid + "border_bits: 1\ncorner_squares: true\n").corner_squares);
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(TargetFile, FirstIdOfTheCallerWins) {
  EXPECT_EQ(tags_of(read(kGrid + "first_id: 7\n")).front().id, 7);
  EXPECT_EQ(tags_of(read(kGrid + "first_id: 7\n", 100)).front().id, 100);
  EXPECT_EQ(tags_of(read(kGrid, 100)).back().id, 129);
  // The smallest id becomes first_id; the others are shifted by the same number.
  EXPECT_EQ(tags_of(read(kTags, 100)).back().id, 105);
  EXPECT_EQ(read_kind<Points>(kPoints, 0).points.back().id.tag_id, 3);
  EXPECT_EQ(tags_of(read(kTags + "first_id: 5\n")).front().id, 5);
}

TEST_F(TargetFile, TagsAndPointsStandWhereTheFileSays) {
  const auto tags = read_kind<Tags>(kTags);
  EXPECT_EQ(tags.family, "tag25h9");
  EXPECT_EQ(tags.border_bits, 1);
  EXPECT_EQ(tags.tags[0].board_from_tag.translation(), Eigen::Vector3d(1, 2, 3));
  const Eigen::Vector3d turned = tags.tags[1].board_from_tag * Eigen::Vector3d(1, 2, 3);
  EXPECT_LT((turned - Eigen::Vector3d(-1, -2, 3)).norm(), 1e-15);
  EXPECT_EQ(tags_of(read("target_type: tags\ntags: [{id: 1, size: 2}]"))[0].size, 2);

  const auto points = read_kind<Points>(kPoints);
  ASSERT_EQ(points.points.size(), 2U);
  EXPECT_EQ(points.points[0].id.tag_id, 4);
  EXPECT_EQ(points.points[0].position, Eigen::Vector3d(1.5, -2e-3, 0.25));
  EXPECT_EQ(points.points[1].position, Eigen::Vector3d(1, 2, 3));
}

TEST_F(TargetFile, PoseMayBeAMatrix) {
  const auto board = read_kind<Tags>(
      "target_type: tags\ntags: [{id: 1, size: 2, pose: "
      "[[0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]]}]");
  const Eigen::Vector3d moved = board.tags[0].board_from_tag * Eigen::Vector3d(1, 0, 0);
  EXPECT_LT((moved - Eigen::Vector3d(5, 7, 7)).norm(), 1e-15);
}

TEST_F(TargetFile, UnknownKeysWarnInKalibrsFiles) {
  read(kGrid + "tagSpacin: 0.3\nauthor: me\n");
  ASSERT_EQ(warnings_.size(), 2U);
  EXPECT_HAS(warnings_[0], "target.yaml: tagSpacin: unknown key; did you mean tagSpacing?");
  EXPECT_HAS(warnings_[1], "author: unknown key; known keys are target_type, tagCols");
}

TEST_F(TargetFile, BadGrids) {
  expect_bad(
      kGrid,
      {{"tagCols: 6", "tagCols: 0", ": tagCols: must be a whole number from 1 to 100000, got 0"},
       {"tagCols: 6", "tagCols: -6", ": tagCols: must be a whole number from 1 to 100000, got -6"},
       {"tagCols: 6", "tagCols: 6.0",
        ": tagCols: must be a whole number from 1 to 100000, got 6.0"},
       {"tagCols: 6", "tagCols: 99999999999", ": tagCols: must be a whole number"},
       {"tagCols: 6", "tagCols: six", ": tagCols: must be a whole number"},
       {"tagCols: 6",
        "tagCols:", ": tagCols: must be a whole number from 1 to 100000, got nothing"},
       {"tagCols: 6", "tagCols: [6]",
        ": tagCols: must be a whole number from 1 to 100000, got a l"},
       {"tagCols: 6", "tagCols: '6'",
        ": tagCols: must be a whole number from 1 to 100000, got \"6"},
       {"tagCols: 6", "tagCols: 50000", ": tagCols * tagRows: must be at most 100000, got 250000"},
       {"tagCols: 6\n", "", ": tagCols: the key is missing"},
       {"tagRows: 5", "tagRows: 5\ntagRows: 6", ": line 4: tagRows: the key is given twice"},
       {"tagSize: 0.088", "tagSize: -0.088", ": tagSize: must be > 0, got -0.088"},
       {"tagSize: 0.088", "tagSize: 0", ": tagSize: must be > 0, got 0"},
       {"tagSize: 0.088", "tagSize: .nan",
        ": tagSize: must be a length in metres, or with its unit (30mm, 3cm, 0.03m, 1in), got "
        ".nan"},
       {"tagSize: 0.088", "tagSize: nan",
        ": tagSize: must be a length in metres, or with its unit (30mm, 3cm, 0.03m, 1in), got nan"},
       {"tagSize: 0.088", "tagSize: .inf",
        ": tagSize: must be a length in metres, or with its unit (30mm, 3cm, 0.03m, 1in), got "
        ".inf"},
       {"tagSize: 0.088", "tagSize: 1e400",
        ": tagSize: must be a length in metres, or with its unit (30mm, 3cm, 0.03m, 1in), got "
        "1e400"},
       {"tagSize: 0.088", "tagSize: 0,088",
        ": tagSize: must be a length in metres, or with its unit (30mm, 3cm, 0.03m, 1in), got "
        "0,088"},
       {"tagSize: 0.088", "tagSize: {a: 1}",
        ": tagSize: must be a length in metres, or with its unit (30mm, 3cm, 0.03m, 1in), got a "
        "map"},
       {"tagSpacing: 0.3", "tagSpacing: -0.3", ": tagSpacing: must be >= 0, got -0.3"},
       {"tagSpacing: 0.3", "tagSpacing: 11mm",
        ": tagSpacing: must be the gap divided by tagSize, 0.125, got 11mm"},
       {"'aprilgrid'", "'aprilgird'",
        ": target_type: must be aprilgrid, tags, checkerboard, charuco, circlegrid or points"},
       {"target_type:", "type:", ": target_type: the key is missing"},
       {"target_type:", "camera_matrix:", ": is a camera's file, not a target file"},
       {"target_type:", "images:", ": is a data set, not a target file"},
       {"tagCols", "border_bits: 3\ntagCols", ": border_bits: must be a whole number from 1 to 2"},
       {"tagCols", "corner_squares: 2\ntagCols", ": corner_squares: must be true or false, got 2"},
       {"tagCols", "family: ''\ntagCols", ": family: must be a text, got \"\""},
       {"tagCols", "first_id: -1\ntagCols", ": first_id: must be a whole number from 0 to"},
       {"tagCols", "first_id: 2147483640\ntagCols", ": first_id: the ids must stay below 2^31"},
       {"tagCols: 6", "\ttagCols: 6", ": line 2: is not YAML: "},
       {"tagCols: 6", "tagCols: [6", ": line 3: is not YAML: "},
       {"tagCols: 6", "tagCols: 6: 7", ": line 2: is not YAML: illegal map value"},
       {"tagCols: 6", "---\ntagCols: 6", ": line 2: a second YAML document begins"},
       {"tagCols: 6", "tagCols: *six", ": line 2: is not YAML: "},
       {"tagCols: 6", "tagCols: &a [*a]", ": line 2: an alias is inside its own anchor"},
       {"tagCols: 6", "? [1, 2]\n: 6", ": line 2: a key must be plain text"}});
}

TEST_F(TargetFile, BadTagsAndPoints) {
  expect_bad(
      kTags,
      {{"id: 8", "id: 3", ": tags[1].id: must differ from the ids before it, got 3"},
       {"id: 8", "id: -8", ": tags[1].id: must be a whole number from 0 to 2147483647, got -8"},
       {"size: 0.2", "size: 0", ": tags[1].size: must be > 0, got 0"},
       {"size: 0.2", "sise: 0.2", ": tags[1].sise: unknown key; did you mean size?"},
       {", size: 0.2", "", ": tags[1].size: the key is missing"},
       {", pose: {rotation: [0, 0, 0, 1]}", "", ": tags[1].pose: the key is missing"},
       {"[0, 0, 0, 1]", "[0, 0, 0]", ": tags[1].pose.rotation: must be a list of 4, got a list of"},
       {"[0, 0, 0, 1]", "[0, 0, 0, 1.1]", ": tags[1].pose.rotation: must be a unit quaternion [w"},
       {"[0, 0, 0, 1]", "[0, 0, 0, x]", ": tags[1].pose.rotation[3]: must be a finite number, got"},
       {"{rotation: [0, 0, 0, 1]}", "5", ": tags[1].pose: must be a map of keys, got 5"},
       {"{rotation: [0, 0, 0, 1]}", "[[1, 0, 0, 0], [0, 2, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]",
        ": tags[1].pose: the upper left 3x3 must be a rotation"},
       {"{rotation: [0, 0, 0, 1]}", "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]",
        ": tags[1].pose: the upper left 3x3 must be a rotation"},
       {"{rotation: [0, 0, 0, 1]}", "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]]",
        ": tags[1].pose: the last row must be [0, 0, 0, 1]"},
       {"family", "corner_squares: true\nfamily",
        ": corner_squares: must be false for target_type"},
       {"family", "tagCols: 3\nfamily",
        ": tagCols: unknown key; known keys are target_type, tags"}});
  expect_bad(kPoints,
             {{"[7, 1, 2, 3]", "[4, 1, 2, 3]", ": points[1][0]: must differ from the ids before"},
              {"[7, 1, 2, 3]", "[7, 1, 2]", ": points[1]: must be a list of 4, got a list of 3"},
              {"[7, 1, 2, 3]", "7", ": points[1]: must be a map of keys, got 7"},
              {"x: 1.5, ", "", ": points[0].x: the key is missing"},
              {"x: 1.5", "x: inf", ": points[0].x: must be a finite number, got inf"},
              {"points:\n", "points: []\nnone:\n", ": none: unknown key"}});
  EXPECT_EQ(error("target_type: points\npoints: []"),
            ": points: must be a list of at least 1, got a list of 0");
}

const Substrate kAllPaper;

TEST_F(TargetFile, BoardsAreOfPaperUnlessStated) {
  for (const std::string& kind : {kGrid, kTags, kPoints, kChecker, kCircles, kCharuco}) {
    EXPECT_EQ(read(kind).substrate, kAllPaper);
    EXPECT_EQ(read(kind + "flatness: paper\nprint: paper\n").substrate, kAllPaper);
    EXPECT_EQ(read(kind + "flatness: glass\nprint: aluminium\n").substrate,
              (Substrate{Material::glass, Material::aluminium}));
    EXPECT_EQ(read(kind + "print: 0.1\nflatness: 3e-4\n").substrate, (Substrate{3e-4, 0.1}));
    EXPECT_TRUE(warnings_.empty());
  }
}

TEST_F(TargetFile, BadSubstrates) {
  const std::string must = ": must be paper, aluminium, glass or a share > 0 and at most 0.1, got ";
  for (const std::string& kind : {kGrid, kTags, kPoints, kChecker, kCircles, kCharuco})
    for (const std::string key : {"flatness", "print"}) {
      const auto wrong = [&](const std::string& value) {
        return error(kind + key + ": " + value + "\n");
      };
      for (const std::string value : {"-0.001", "0", "-0.0", "0.11", "1e300", "nan", ".nan", "inf",
                                      ".inf", "1e400", "bronze", "Glass", "0.1 %", "true"})
        EXPECT_EQ(wrong(value), ": " + key + must + value);
      EXPECT_EQ(wrong("'0.001'"), ": " + key + must + "\"0.001\"");
      EXPECT_EQ(wrong("[glass]"), ": " + key + must + "a list of 1");
      EXPECT_EQ(wrong("{of: glass}"), ": " + key + must + "a map");
      EXPECT_EQ(wrong(""), ": " + key + must + "nothing");
      EXPECT_EQ(wrong("''"), ": " + key + ": must be a text, got \"\"");
    }
}

TEST_F(TargetFile, SubstratesAreWrittenIfNotOfPaper) {
  for (const std::string& kind : {kGrid, kTags, kPoints, kChecker, kCircles, kCharuco}) {
    Board board = read(kind);
    const auto written = [&] {
      write_target(folder_ / "t.yaml", board);
      return read_text(folder_ / "t.yaml");
    };
    const std::string plain = written();
    EXPECT_LACKS(plain, "flatness");
    EXPECT_LACKS(plain, "print");
    board.substrate = {Material::glass, Material::paper};
    EXPECT_EQ(written(), plain + "flatness: glass\n");
    board.substrate = {Material::aluminium, 0.1 / 3};
    EXPECT_EQ(written(), plain + "flatness: aluminium\nprint: 0.03333333333333333\n");
    EXPECT_EQ(read_target(folder_ / "t.yaml", {}, &warnings_).substrate, board.substrate);
    EXPECT_TRUE(warnings_.empty());
  }
}

TEST_F(TargetFile, WhatIsNoYamlAtAll) {
  EXPECT_EQ(error(""), ": is empty");
  EXPECT_EQ(error("# nothing\n\n"), ": is empty");
  EXPECT_EQ(error("just words"), ": must be a map of keys, got just words");
  EXPECT_EQ(error("- 1\n- 2"), ": must be a map of keys, got a list of 2");
  EXPECT_EQ(error(std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16)), ": is not YAML: binary data");
  EXPECT_ERROR(read_target(folder_ / "none.yaml"),
               (folder_ / "none.yaml").string() + ": no such file");
  EXPECT_ERROR(read_target(folder_), folder_.string() + ": is a folder, not a file");
  EXPECT_EQ(error(std::string((16 << 20) + 1, ' ')), ": larger than 16 MiB");
}

TEST_F(TargetFile, DeepNestingIsRefusedBeforeItOverflowsTheStack) {
  std::string block, keys;
  for (int i = 0; i < 100'000; ++i) {
    block += "- ";
    keys += "? ";
  }
  const std::string brackets = std::string(100'000, '[') + std::string(100'000, ']');
  std::string indented;
  for (int i = 0; i < 200; ++i) indented += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  for (const std::string& deep : {brackets, block, indented}) {
    const std::string message = error(deep);
    EXPECT_HAS(message, "nested more than 64 levels deep");
  }
  // A list or a map as the key of a map.
  for (const std::string& deep : {std::string(100'000, '['), std::string(100'000, '{'), keys}) {
    EXPECT_EQ(error(deep), ": line 1: a key must be plain text");
  }
}

TEST_F(TargetFile, WhatWasWrittenReadsBackTheSame) {
  Random random(5);
  Tags tags{"tag25h9", 1, {}};
  Points points;
  for (int i = 0; i < 200; ++i) {
    tags.tags.push_back({3 * i, random.uniform(), pose_of_many_sizes(random)});
    points.points.push_back({{200 - i, 0}, pose_of_many_sizes(random).translation()});
  }
  const std::vector<BoardPattern> patterns = {
      points, tags, AprilGrid{7, 3, 0.1 / 3, 0.3 / 7, 11, "tag25h9", 1, true},
      Checkerboard{5, 4, 0.1 / 3, 0.1 / 7, false, 3},
      Charuco{6, 5, 0.1 / 3, 0.1 / 7, "DICT_5X5_100", true, 3, 2}};
  for (const BoardPattern& pattern : patterns) {
    const Board board = make_board(pattern);
    write_target(folder_ / "t.yaml", board);
    const Board back = read_target(folder_ / "t.yaml", {}, &warnings_);
    EXPECT_TRUE(warnings_.empty());
    ASSERT_EQ(back.pattern.index(), board.pattern.index());
    const auto of_tags = [](const Board& b) { return tag_kind(b).value_or(TagKind{"none"}); };
    EXPECT_EQ(of_tags(back).family, of_tags(board).family);
    EXPECT_EQ(of_tags(back).border_bits, of_tags(board).border_bits);
    const auto points_back = target_points(back), points_there = target_points(board);
    ASSERT_EQ(points_back.size(), points_there.size());
    for (std::size_t i = 0; i < points_back.size(); ++i) {
      EXPECT_EQ(points_back[i].id, points_there[i].id);
      EXPECT_EQ(points_back[i].position, points_there[i].position);
    }
    const auto tags_back = tags_of(back), tags_there = tags_of(board);
    ASSERT_EQ(tags_back.size(), tags_there.size());
    for (std::size_t i = 0; i < tags_back.size(); ++i) {
      EXPECT_EQ(tags_back[i].id, tags_there[i].id);
      EXPECT_EQ(tags_back[i].size, tags_there[i].size);
      EXPECT_TRUE(same(tags_back[i].board_from_tag, tags_there[i].board_from_tag));
    }
  }
  write_target(folder_ / "t.yaml", make_board(patterns[2]));
  EXPECT_TRUE(std::get<AprilGrid>(read_target(folder_ / "t.yaml").pattern).corner_squares);
  write_target(folder_ / "t.yaml", make_board(points));  // in the order of the file
  EXPECT_EQ(std::get<Points>(read_target(folder_ / "t.yaml").pattern).points[0].id.tag_id, 200);
}

RC_GTEST_FIXTURE_PROP(TargetFile, ManglesEndInAnErrorOrAValidBoard, (std::uint64_t seed)) {
  Random random(seed);
  for (const std::string& good : {kGrid, kTags, kPoints, kChecker, kCircles, kCharuco}) {
    const std::string text = mutated(good + "flatness: 0.001\nprint: glass\n", random);
    Board board;
    try {
      board = read(text);
    } catch (const Error& error) {
      RC_ASSERT(std::string(error.what()).find("target.yaml: ") != std::string::npos);
      continue;
    }
    RC_ASSERT(!target_points(board).empty());
    check_substrate(board.substrate);
    std::set<int> ids;
    for (const Tag& tag : tags_of(board)) {
      RC_ASSERT(tag.size > 0 && tag.id >= 0 && ids.insert(tag.id).second);
      RC_ASSERT(tag.board_from_tag.matrix().allFinite());
    }
    std::set<CornerId> corners;
    for (const TargetPoint& point : target_points(board))
      RC_ASSERT(point.position.allFinite() && corners.insert(point.id).second);
  }
}

}  // namespace
}  // namespace tagcal
