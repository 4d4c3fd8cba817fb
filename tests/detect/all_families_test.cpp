// Boards and single tags of every family, rendered and found again; tags without a board.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "false_tag_pictures.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal {
namespace {

// Two rows of three tags, 60 px a side, seen at an angle.
struct Sight {
  explicit Sight(const std::string& family, double noise_levels) {
    const int last = static_cast<int>(tag_family(family, 1).codes.size()) - 1;
    Tags board{family, 1, tags_of(make_board(AprilGrid{3, 2, 0.05, 1.5}))};
    board.tags.back().id = last;
    scene.camera = {pinhole(600, 600, 319.5, 239.5), {640, 480}};
    scene.boards = {{make_board(board), Pose()}};
    scene.sensor = {.blur_px = 0.7, .noise_levels = noise_levels};
    camera_from_world =
        camera_from_world_looking_at({0.3, -0.05, 0.45}, {0.15, 0.09, 0}, {0, 1, 0});
    const TagFamilies families = {{family, tag_family(family, 1)}};
    picture = expose(render_light(scene, families, camera_from_world), scene.sensor, 5);
    for (const Observation& o : visible_corners(scene, camera_from_world)) exact[o.id] = o.pixel;
  }

  Scene scene;
  Pose camera_from_world;
  Image8 picture;
  std::map<CornerId, Eigen::Vector2d> exact;
};

struct Errors {
  double largest_px = 0;
  double squares = 0;  // in units of the covariances
  int corners = 0;

  void add(const Eigen::Vector2d& error, const Eigen::Matrix2d& covariance_px2) {
    largest_px = std::max(largest_px, error.norm());
    squares += error.dot(covariance_px2.inverse() * error) / 2;
    ++corners;
  }
  double nees() const { return squares / corners; }
};

TEST(AllFamilies, AreTheNineOfAprilTag) { EXPECT_EQ(tag_family_names().size(), 9u); }

TEST(AllFamilies, BoardsAreFoundAtTheirExactCorners) {
  for (const std::string& family : tag_family_names()) {
    for (const double noise : {0.0, 2.0}) {
      const Sight sight(family, noise);
      ASSERT_EQ(sight.exact.size(), 24u);
      const View view = detect(sight.picture, sight.scene.boards).view;
      EXPECT_EQ(view.observations.size(), 24u) << family;
      Errors errors;
      for (const Observation& seen : view.observations) {
        ASSERT_TRUE(seen.covariance_px2.has_value());
        errors.add(seen.pixel - sight.exact.at(seen.id), *seen.covariance_px2);
      }
      std::printf("%-17s noise %.0f: at most %.4f px, NEES %.2f\n", family.c_str(), noise,
                  errors.largest_px, errors.nees());
      EXPECT_LT(errors.largest_px, noise > 0 ? 0.04 : 0.01) << family;
      // Without noise the errors are those of rounding, a few thousandths of a pixel.
      EXPECT_LT(errors.nees(), noise > 0 ? 1.6 : 6) << family;
    }
  }
}

TEST(AllFamilies, TagsAreFoundWithoutABoard) {
  for (const std::string& family : tag_family_names()) {
    const Sight sight(family, 2);
    const std::vector<DetectedTag> tags = detect_tags(sight.picture, {.family = family});
    EXPECT_EQ(tags.size(), 6u) << family;
    Errors errors;
    for (const DetectedTag& tag : tags) {
      ASSERT_TRUE(tag.covariance_px2.has_value());
      for (int i = 0; i < 4; ++i) {
        const auto exact = sight.exact.find({tag.id, i});
        ASSERT_NE(exact, sight.exact.end()) << family << " has no tag " << tag.id;
        errors.add(tag.corners[static_cast<std::size_t>(i)] - exact->second,
                   tag.covariance_px2->block<2, 2>(2 * i, 2 * i));
      }
    }
    EXPECT_LT(errors.largest_px, 0.04) << family;
    EXPECT_LT(errors.nees(), 1.6) << family;
  }
}

TEST(DetectTags, RepeatedIdsAreReportedFromLeftToRight) {
  Scene scene;
  scene.camera = {pinhole(600, 600, 319.5, 239.5), {640, 480}};
  for (const double x : {0.1, -0.1, 0.0}) {
    Board board = make_board(AprilGrid{1, 1, 0.05, 0.5, 7, "tag36h11", 1, false});
    scene.boards.push_back({board, translation({x, 0, 0})});
  }
  scene.sensor = {.blur_px = 0.7, .noise_levels = 2};
  const Pose above = camera_from_world_looking_at({0, 0, 0.5}, {0, 0, 0}, {0, 1, 0});
  const TagFamilies families = {{"tag36h11", tag_family("tag36h11", 1)}};
  const Image8 picture = expose(render_light(scene, families, above), scene.sensor, 1);
  const std::vector<DetectedTag> tags = detect_tags(picture, {});
  ASSERT_EQ(tags.size(), 3u);
  for (const DetectedTag& tag : tags) EXPECT_EQ(tag.id, 7);
  EXPECT_LT(tags[0].corners[0].x() + 60, tags[1].corners[0].x());
  EXPECT_LT(tags[1].corners[0].x() + 60, tags[2].corners[0].x());
  const std::vector<ImageSource> images(3, {"a.png", [&] { return picture; }});
  const auto all = detect_all_tags(images, {}, {.threads = 2});
  ASSERT_EQ(all.size(), 3u);
  for (const PictureTags& again : all) {
    ASSERT_EQ(again.tags.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(again.tags[i].corners, tags[i].corners);
  }
}

TEST(DetectTags, PicturesWithoutTagsShowNone) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
    for (const char* family : {"tag36h11", "tag16h5", "tagCircle21h7"})
      found += static_cast<int>(detect_tags(picture_without_tags(seed), {family, 1}).size());
  EXPECT_EQ(found, 0);
  EXPECT_TRUE(detect_tags(Image8({640, 480}, 128), {}).empty());
  EXPECT_TRUE(detect_tags(Image8({4, 4}, 128), {}).empty());
  EXPECT_TRUE(detect_tags(Image8(), {}).empty());
  EXPECT_THROW(detect_tags(Image8({64, 48}), {"tag36h12", 1}), Error);
  EXPECT_THROW(detect_tags(Image8({64, 48}), {"tagStandard41h12", 2}), Error);
  const Camera camera{pinhole(600, 600, 319.5, 239.5), {640, 480}};
  EXPECT_THROW(detect_tags(Image8({64, 48}), {}, {.camera = &camera}), Error);
}

// The memory of another library: a part of a larger picture, whose rows are farther apart.
TEST(ImageView, OfAPartOfAPictureIsSearchedInPlace) {
  const Sight sight("tag36h11", 2);
  Image8 larger({700, 500}, 90);
  for (int y = 0; y < 480; ++y) std::copy_n(sight.picture.row(y), 640, larger.row(y + 15) + 30);
  const ImageView8 part(larger.row(15) + 30, {640, 480}, larger.width());
  const View expected = detect(sight.picture, sight.scene.boards).view;
  const View found = detect(part, sight.scene.boards).view;
  ASSERT_EQ(found.observations.size(), expected.observations.size());
  for (std::size_t i = 0; i < found.observations.size(); ++i)
    EXPECT_EQ(found.observations[i].pixel, expected.observations[i].pixel);
}

}  // namespace
}  // namespace tagcal
