#include "tagcal/detect/explain.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <tuple>

#include "expect.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/scene/render.hpp"

namespace tagcal {
namespace {

Board grid_of(const std::string& family, int border_bits, double spacing = 0.3) {
  return make_board(AprilGrid{4, 3, 0.06, spacing, 0, family, border_bits, border_bits == 2});
}

Image8 picture_of(const Board& board, double distance_m = 0.5) {
  Scene scene;
  scene.camera = {pinhole(500, 500, 239.5, 179.5), {480, 360}};
  scene.boards = {{board, Pose()}};
  scene.sensor = {1, 0.7, 2};
  const Eigen::Quaterniond facing(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.5, 1, 0).normalized()));
  const Eigen::Quaterniond rotation = tilt * facing;
  const Pose pose(rotation,
                  Eigen::Vector3d(0, 0, distance_m) - rotation * Eigen::Vector3d(0.15, 0.11, 0));
  return expose(render_light(scene, tag_families(scene.boards), pose), scene.sensor, 3);
}

Explanation explained(const Image8& image, const Board& board) {
  return explain(image, {{board, Pose()}});
}

Image8 changed(const Image8& image, bool mirror, bool invert) {
  Image8 result(image.size());
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const std::uint8_t level = image(mirror ? image.width() - 1 - x : x, y);
      result(x, y) = invert ? static_cast<std::uint8_t>(255 - level) : level;
    }
  return result;
}

void expect_one_mistake(const Explanation& e, const std::string& start) {
  ASSERT_EQ(e.mistakes.size(), 1u) << start;
  EXPECT_TRUE(e.mistakes[0].starts_with(start)) << e.mistakes[0];
}

TEST(Explain, NothingIsWrongWithAGoodPicture) {
  for (const int border : {1, 2}) {
    const Board board = grid_of("tag36h11", border);
    const Explanation e = explained(picture_of(board), board);
    EXPECT_EQ(e.reported.size(), 12u);
    EXPECT_TRUE(e.not_reported.empty());
    EXPECT_TRUE(e.mistakes.empty()) << e.mistakes[0];
    EXPECT_GE(e.quads, 12);
    ASSERT_EQ(e.decoded.size(), 1u);
    EXPECT_EQ(e.decoded[0].family, "tag36h11");
    EXPECT_EQ(e.decoded[0].border_bits, border);
  }
}

TEST(Explain, WrongFamilyBorderAndIds) {
  const Image8 plain = picture_of(grid_of("tag36h11", 1));
  expect_one_mistake(explained(plain, grid_of("tag25h9", 1)), "wrong family: 12 tags of tag36h11");
  expect_one_mistake(explained(plain, grid_of("tag36h11", 2)), "wrong border: 12 tags of tag36h11");
  const Image8 kalibr = picture_of(grid_of("tag36h11", 2));
  expect_one_mistake(explained(kalibr, grid_of("tag36h11", 1)), "wrong border: ");
  Board other = make_board(AprilGrid{4, 3, 0.06, 0.3, 100, "tag36h11", 1, false});
  expect_one_mistake(explained(plain, other), "wrong ids: 12 tags");
}

// Two prints of one tag in a picture: the ids are right, and each is seen twice.
TEST(Explain, IdsSeenTwiceAreNotWrong) {
  Scene scene;
  scene.camera = {pinhole(500, 500, 239.5, 179.5), {480, 360}};
  const Pose left(Eigen::Quaterniond::Identity(), {-0.12, 0, 0});
  const Pose right(Eigen::Quaterniond::Identity(), {0.12, 0, 0});
  const Board tag = make_board(AprilGrid{1, 1, 0.08, 0.3, 3, "tag36h11", 1, false});
  scene.boards = {{tag, left}};
  scene.sensor = {1, 0.7, 2};
  const Eigen::Quaterniond facing(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  const auto view = [&](const Pose& place) {
    scene.boards = {{tag, place}};
    return expose(
        render_light(scene, tag_families(scene.boards), Pose(facing, Eigen::Vector3d(0, 0, 0.5))),
        scene.sensor, 3);
  };
  Image8 both = view(left);
  const Image8 other = view(right);
  for (int y = 0; y < both.height(); ++y)
    for (int x = both.width() / 2; x < both.width(); ++x) both(x, y) = other(x, y);
  const Explanation e = explained(both, tag);
  EXPECT_TRUE(e.mistakes.empty()) << e.mistakes[0];
  ASSERT_EQ(e.not_reported.size(), 1u);
  EXPECT_EQ(e.not_reported[0].why, "seen more than once");
}

struct Detected {
  std::vector<DetectedPicture> pictures;
  std::vector<std::string> warnings;
};

Detected detected(const std::vector<Image8>& images, const Board& board) {
  std::vector<ImageSource> sources;
  for (const Image8& image : images)
    sources.push_back({std::to_string(sources.size()) + ".png", [&image] { return image; }});
  const DetectOptions options{.threads = 2};
  Detected result{detect_all(sources, {{board, Pose()}}, options), {}};
  result.warnings = board_warnings(
      {{board, Pose()}}, target_mistakes(sources, result.pictures, {{board, Pose()}}, options));
  return result;
}

// `detect` and `calibrate` say so, too, of all pictures in one warning.
TEST(WrongBorder, IsNamedFirstAmongTheWarnings) {
  for (const int border : {1, 2}) {
    const Image8 image = picture_of(grid_of("tag36h11", border));
    const Detected wrong =
        detected({image, image, image, image, image}, grid_of("tag36h11", 3 - border));
    ASSERT_FALSE(wrong.warnings.empty())
        << border << ": " << wrong.pictures[0].view.observations.size() << " corners";
    EXPECT_TRUE(wrong.warnings[0].starts_with(
        "the pictures and the target file do not agree: wrong border: 12 tags of tag36h11"))
        << wrong.warnings[0];
    EXPECT_TRUE(wrong.warnings[0].ends_with("write border_bits: " + std::to_string(border)))
        << wrong.warnings[0];
    EXPECT_TRUE(detected({image}, grid_of("tag36h11", border)).warnings.empty());
  }
}

// Pictures without the board, or with little of it, are no wrong border.
TEST(WrongBorder, IsNotNamedForPicturesThatShowLittle) {
  const Board board = grid_of("tag36h11", 1);
  Image8 hidden = picture_of(board);
  for (int y = 0; y < hidden.height(); ++y)
    for (int x = hidden.width() / 3; x < hidden.width(); ++x) hidden(x, y) = 128;
  const Detected little = detected({hidden, Image8({480, 360}, 128)}, board);
  EXPECT_GT(little.pictures[0].view.observations.size(), 4u);
  EXPECT_TRUE(little.warnings.empty());
  ASSERT_EQ(little.pictures[1].warnings.size(), 1u);
  EXPECT_EQ(little.pictures[1].warnings[0], "1.png: no tag of the boards found");
}

TEST(Explain, MirroredAndInverted) {
  const Board board = grid_of("tag36h11", 1);
  const Image8 image = picture_of(board);
  expect_one_mistake(explained(changed(image, true, false), board), "mirrored picture: 12 tags");
  expect_one_mistake(explained(changed(image, false, true), board), "light on dark: ");
}

TEST(Explain, SpacingInMetresIsNamed) {
  const Image8 image = picture_of(grid_of("tag36h11", 2));
  const Explanation e = explained(image, grid_of("tag36h11", 2, 0.018));
  ASSERT_EQ(e.mistakes.size(), 1u);
  EXPECT_HAS(e.mistakes[0], "0.30 of a tag's side");
  EXPECT_HAS(e.mistakes[0], "looks like metres");
  const Explanation other = explained(image, grid_of("tag36h11", 2, 0.5));
  ASSERT_EQ(other.mistakes.size(), 1u);
  EXPECT_LACKS(other.mistakes[0], "metres");
}

// An AprilGrid of 4 x 3 tags, with other numbers of tags in the file; then ChArUco boards.
TEST(Explain, WrongColumns) {
  const Image8 image = picture_of(grid_of("tag36h11", 1));
  for (const int columns : {3, 5, 6, 12}) {
    const Board wrong = make_board(AprilGrid{columns, 4, 0.06, 0.3, 0, "tag36h11", 1, false});
    const Explanation e = explained(image, wrong);
    ASSERT_FALSE(e.mistakes.empty()) << columns;
    EXPECT_TRUE(e.mistakes[0].starts_with("wrong columns: ")) << e.mistakes[0];
    EXPECT_TRUE(e.mistakes[0].ends_with("write tagCols: 4")) << e.mistakes[0];
    const Detected set = detected({image, image}, wrong);
    ASSERT_FALSE(set.warnings.empty());
    EXPECT_HAS(set.warnings[0], "write tagCols: 4");
  }
}

Charuco charuco(int columns, int rows, bool legacy) {
  return {columns, rows, 0.04, 0.03, "DICT_4X4_250", legacy};
}

struct WrongCharuco {
  Charuco file;
  std::string start, end;
};

TEST(Explain, WrongCharucoBoards) {
  Charuco other_size = charuco(7, 6, false), other_dictionary = charuco(7, 6, false);
  other_size.marker_size = 0.024;
  other_dictionary.dictionary = "DICT_5X5_100";
  const std::vector<WrongCharuco> of_wide = {
      {charuco(6, 7, false), "wrong squares: ", "write squareCols: 7, squareRows: 6"},
      {charuco(6, 5, false), "wrong squares: ", "write squareCols: 7, squareRows: 6"},
      {charuco(7, 6, true), "wrong pattern: ", "write legacy: false"},
      {other_size, "wrong marker size: ", "write markerSize: 0.03"},
      {other_dictionary, "wrong dictionary: ", "write dictionary: DICT_4X4_50"}};
  const Image8 image = picture_of(make_board(charuco(7, 6, false)));
  EXPECT_TRUE(explained(image, make_board(charuco(7, 6, false))).mistakes.empty());
  for (const WrongCharuco& wrong : of_wide) {
    const Explanation e = explained(image, make_board(wrong.file));
    ASSERT_EQ(e.mistakes.size(), 1u) << wrong.start;
    EXPECT_TRUE(e.mistakes[0].starts_with(wrong.start)) << e.mistakes[0];
    EXPECT_HAS(e.mistakes[0], wrong.end);
    const Detected set = detected({image}, make_board(wrong.file));
    EXPECT_TRUE(std::ranges::any_of(set.warnings, [&](const std::string& warning) {
      return warning.find(wrong.start) != std::string::npos;
    })) << wrong.start;
  }
  // A dictionary that has the markers of the whole board, of which the picture shows a part.
  Charuco larger = charuco(7, 20, false);
  larger.dictionary = "DICT_5X5_100";
  expect_one_mistake(explained(image, make_board(larger)),
                     "wrong dictionary: 21 markers of DICT_4X4_100 are in the picture, but the "
                     "target file says DICT_5X5_100; write dictionary: DICT_4X4_100");
  const Image8 legacy = picture_of(make_board(charuco(7, 6, true)));
  const Explanation e = explained(legacy, make_board(charuco(7, 6, false)));
  ASSERT_EQ(e.mistakes.size(), 1u);
  EXPECT_TRUE(e.mistakes[0].ends_with("write legacy: true")) << e.mistakes[0];
  EXPECT_TRUE(explained(legacy, make_board(charuco(7, 6, true))).mistakes.empty());
  // What is advised is not what the file says already.
  for (const bool in_file : {false, true}) {
    const Explanation odd = explained(legacy, make_board(charuco(7, 7, in_file)));
    ASSERT_EQ(odd.mistakes.size(), 1u);
    EXPECT_TRUE(odd.mistakes[0].ends_with(in_file ? "even number" : "even number, legacy: true"))
        << odd.mistakes[0];
  }
}

// AprilTag's tags are a dictionary, too: the squares tell.
TEST(Explain, AnAprilGridBeforeACharucoFile) {
  expect_one_mistake(
      explained(picture_of(grid_of("tag36h11", 1)), make_board(charuco(7, 6, false))),
      "wrong target_type: the picture shows 12 tags of tag36h11, but the target file "
      "says target_type: charuco; write target_type: aprilgrid");
  Charuco apriltag = charuco(7, 6, false);
  apriltag.dictionary = "DICT_APRILTAG_36h11";
  const Explanation e =
      explained(picture_of(make_board(apriltag)), make_board(charuco(7, 6, false)));
  expect_one_mistake(e, "wrong dictionary: ");
  EXPECT_HAS(e.mistakes[0], "write dictionary: DICT_APRILTAG_36h11");
}

// A column of the board has places of another one, or all tags are a row off.
TEST(Explain, WrongFirstIds) {
  const Image8 image = picture_of(grid_of("tag36h11", 1));
  for (const int first : {1, 4}) {
    const Board wrong = make_board(AprilGrid{4, 3, 0.06, 0.3, first, "tag36h11", 1, false});
    expect_one_mistake(explained(image, wrong),
                       "wrong first id: the ids in the picture, 0 to 11, are in the places of a "
                       "board whose ids begin with 0, but the target file says " +
                           std::to_string(first) + "; write first_id: 0");
    const Detected set = detected({image}, wrong);
    EXPECT_TRUE(std::ranges::any_of(set.warnings, [](const std::string& warning) {
      return warning.ends_with("write first_id: 0");
    }));
  }
  Charuco markers = charuco(7, 6, false);
  const Image8 squares = picture_of(make_board(markers));
  markers.first_marker_id = 1;
  const Explanation e = explained(squares, make_board(markers));
  expect_one_mistake(e, "wrong first id: ");
  EXPECT_TRUE(e.mistakes[0].ends_with("write first_marker_id: 0")) << e.mistakes[0];
  EXPECT_TRUE(std::ranges::any_of(
      detected({squares}, make_board(markers)).warnings,
      [](const std::string& warning) { return warning.ends_with("write first_marker_id: 0"); }));
}

// Pictures of a board with markers that were left out are not loaded for its mistakes.
TEST(Explain, FilesThatCannotBeReadAreLeftOut) {
  const std::vector<PlacedBoard> boards = {{make_board(charuco(7, 6, false)), Pose()}};
  const ImageSource damaged{"damaged.png", []() -> Image8 { throw Error("is truncated"); }};
  const ImageSource grey{"grey.png", [] { return Image8({480, 360}, 128); }};
  DetectOptions options;
  options.skip_unreadable = true;
  for (const std::vector<ImageSource>& images :
       {std::vector{damaged}, std::vector{damaged, damaged, grey}}) {
    const auto found = detect_all(images, boards, options);
    EXPECT_EQ(found[0].unreadable, "is truncated");
    EXPECT_TRUE(target_mistakes(images, found, boards, options).empty());
  }
}

// The ids of the rows that are there are right.
TEST(WrongRows, AreNamedIfPicturesHaveRoomForThem) {
  const Image8 tags = picture_of(grid_of("tag36h11", 1), 0.9);
  const auto warnings = [](const Image8& image, const Board& board) {
    return detected({image, image, image}, board).warnings;
  };
  for (const int more : {1, 2, 5}) {
    const auto said =
        warnings(tags, make_board(AprilGrid{4, 3 + more, 0.06, 0.3, 0, "tag36h11", 1, false}));
    ASSERT_EQ(said.size(), 1U) << more;
    EXPECT_HAS(said[0], "wrong rows: the pictures show 3 of the");
    EXPECT_TRUE(said[0].ends_with("write tagRows: 3")) << said[0];
  }
  EXPECT_TRUE(warnings(tags, grid_of("tag36h11", 1)).empty());
}

// The lower edge of the board is found as corners, too: the number of rows is that of the markers.
TEST(WrongRows, OfCharucoBoardsAreThoseOfThePictures) {
  for (const bool legacy : {false, true}) {
    const Image8 image = picture_of(make_board(charuco(7, 6, legacy)), legacy ? 1.0 : 0.7);
    const auto warnings = [&](int rows) {
      return detected({image, image, image}, make_board(charuco(7, rows, legacy))).warnings;
    };
    EXPECT_TRUE(warnings(6).empty());
    for (const int rows : {7, 10}) {
      if (legacy && rows == 7) continue;  // its pattern differs
      const auto said = warnings(rows);
      ASSERT_EQ(said.size(), 1U) << rows;
      const std::string start =
          "wrong rows: the pictures show 6 of the " + std::to_string(rows) + " rows of squares";
      EXPECT_HAS(said[0], start);
      EXPECT_TRUE(said[0].ends_with("write squareRows: 6")) << said[0];
    }
  }
}

// The board in the picture has 9 rows. The lowest ones are outside, or hidden in all but a few
// pictures, so that nothing can be said of their number.
TEST(WrongRows, OfCharucoBoardsSeenInPartAreNotNamed) {
  const Image8 whole = picture_of(make_board(charuco(7, 9, false)), 0.9);
  const ImageSize upper{whole.width(), 235};
  Image8 cut(upper), hidden = whole;
  for (int y = 0; y < whole.height(); ++y)
    for (int x = 0; x < whole.width(); ++x) {
      if (y < upper.height) cut(x, y) = whole(x, y);
      if (y >= upper.height) hidden(x, y) = 128;
    }
  for (const int rows : {9, 11}) {
    const Detected set = detected({cut, cut, cut, cut}, make_board(charuco(7, rows, false)));
    EXPECT_GT(set.pictures[0].view.observations.size(), 20U);
    EXPECT_TRUE(set.warnings.empty()) << set.warnings[0];
  }
  const Board board = make_board(charuco(7, 9, false));
  const Detected set = detected({hidden, hidden, hidden, hidden, whole}, board);
  EXPECT_TRUE(set.warnings.empty()) << set.warnings[0];
}

Board checkerboard(int columns, int rows) {
  return make_board(Checkerboard{columns, rows, 0.04, 0.04});
}

TEST(Explain, WrongSizesOfCheckerboards) {
  const Image8 image = picture_of(checkerboard(6, 5));
  for (const auto& [columns, rows] : {std::pair(5, 4), {7, 6}, {6, 4}, {8, 8}}) {
    const Board wrong = checkerboard(columns, rows);
    const Detected set = detected({image, image, image}, wrong);
    ASSERT_FALSE(set.warnings.empty()) << columns;
    const std::string& warning = set.warnings[set.warnings.size() - 1];
    EXPECT_HAS(warning, "write targetCols: 6, targetRows: 5");
    EXPECT_EQ(warning.find("squares") != std::string::npos, columns == 7) << warning;
  }
  // One picture with a part of the board is no mistake.
  EXPECT_TRUE(explained(image, checkerboard(8, 8)).mistakes.empty());
  EXPECT_TRUE(detected({image, image}, checkerboard(5, 6)).pictures[0].warnings.empty());
}

TEST(Explain, TargetsOfAnotherTypeAreNamed) {
  const Board tags = grid_of("tag36h11", 2), squares = checkerboard(6, 5);
  const Board markers = make_board(charuco(7, 6, false));
  const Board circles = make_board(CircleGrid{5, 4, 0.05, 0.02});
  const std::string of_tags = "wrong target_type: the picture shows 12 tags of tag36h11, but ";
  const std::string of_markers = "wrong target_type: the picture shows 21 markers of DICT_4X4_50, ";
  const std::string of_squares =
      "wrong target_type: the picture shows a grid of 6 x 5 corners, but the target file says "
      "target_type: ";
  const std::vector<std::tuple<Board, Board, std::string>> table = {
      {tags, squares, of_tags},       {tags, markers, of_tags},       {tags, circles, of_tags},
      {markers, tags, of_markers},    {markers, squares, of_markers}, {squares, tags, of_squares},
      {squares, markers, of_squares}, {squares, circles, of_squares}};
  for (const auto& [seen, in_file, start] : table) {
    const Image8 image = picture_of(seen);
    SCOPED_TRACE(start);
    expect_one_mistake(explained(image, in_file), start);
    const Detected set = detected({image, image, image}, in_file);
    EXPECT_TRUE(std::ranges::any_of(set.warnings, [&](const std::string& warning) {
      return warning.find(start) != std::string::npos;
    }));
  }
  EXPECT_TRUE(explained(Image8({480, 360}, 128), tags).mistakes.empty());
}

TEST(Explain, SmallPictures) {
  const Board board = grid_of("tag36h11", 1);
  for (const ImageSize size : {ImageSize{3, 3}, ImageSize{100, 80}})
    expect_one_mistake(explained(Image8(size, 128), board), "picture too small");
}

}  // namespace
}  // namespace tagcal
