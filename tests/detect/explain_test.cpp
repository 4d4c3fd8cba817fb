#include "tagcal/detect/explain.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/scene/render.hpp"

namespace tagcal {
namespace {

Board grid_of(const std::string& family, int border_bits, double spacing = 0.3) {
  return make_board(AprilGrid{4, 3, 0.06, spacing, 0, family, border_bits, border_bits == 2});
}

Image8 picture_of(const Board& board) {
  Scene scene;
  scene.camera = {pinhole(500, 500, 239.5, 179.5), {480, 360}};
  scene.boards = {{board, Pose()}};
  scene.sensor = {1, 0.7, 2};
  const Eigen::Quaterniond facing(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.5, 1, 0).normalized()));
  const Eigen::Quaterniond rotation = tilt * facing;
  const Pose pose(rotation, Eigen::Vector3d(0, 0, 0.5) - rotation * Eigen::Vector3d(0.15, 0.11, 0));
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
  result.warnings = board_warnings(sources, result.pictures, {{board, Pose()}}, options);
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
    EXPECT_TRUE(wrong.warnings[0].starts_with("the tags in 5 of 5 pictures have a border of " +
                                              std::to_string(border)))
        << wrong.warnings[0];
    EXPECT_TRUE(wrong.warnings[0].ends_with("Put border_bits: " + std::to_string(border) +
                                            " into the target file"))
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
  expect_one_mistake(explained(changed(image, false, true), board), "inverted picture: ");
}

TEST(Explain, SpacingInMetresIsNamed) {
  const Image8 image = picture_of(grid_of("tag36h11", 2));
  const Explanation e = explained(image, grid_of("tag36h11", 2, 0.018));
  ASSERT_EQ(e.mistakes.size(), 1u);
  EXPECT_NE(e.mistakes[0].find("0.30 of a tag's side"), std::string::npos) << e.mistakes[0];
  EXPECT_NE(e.mistakes[0].find("looks like metres"), std::string::npos) << e.mistakes[0];
  const Explanation other = explained(image, grid_of("tag36h11", 2, 0.5));
  ASSERT_EQ(other.mistakes.size(), 1u);
  EXPECT_EQ(other.mistakes[0].find("metres"), std::string::npos) << other.mistakes[0];
}

TEST(Explain, SmallPictures) {
  const Board board = grid_of("tag36h11", 1);
  for (const ImageSize size : {ImageSize{3, 3}, ImageSize{100, 80}})
    expect_one_mistake(explained(Image8(size, 128), board), "picture too small");
}

}  // namespace
}  // namespace tagcal
