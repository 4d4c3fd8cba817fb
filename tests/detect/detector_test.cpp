#include "tagcal/detect/detector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "expect.hpp"
#include "tag_patch.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal {
namespace {

PlacedBoard board_of(const std::string& family, int border_bits, int first_id, int count) {
  Tags board{family, border_bits, {}};
  // Each on a plane of its own: no tag says where another one is.
  for (int id = first_id; id < first_id + count; ++id) {
    const Pose pose(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, id));
    board.tags.push_back({id, 0.1, pose});
  }
  return {make_board(board), Pose()};
}

// Kalibr's tags, each a grid of its own.
std::vector<PlacedBoard> kalibr_tags(int count) {
  std::vector<PlacedBoard> boards;
  for (int id = 0; id < count; ++id)
    boards.push_back({make_board(AprilGrid{1, 1, 0.1, 0.3, id}), Pose()});
  return boards;
}

std::vector<ImageSource> sources_of(const std::vector<Patch>& patches) {
  std::vector<ImageSource> sources;
  for (const Patch& patch : patches) {
    sources.push_back({std::to_string(sources.size()), [&patch] { return patch.image; }});
  }
  return sources;
}

std::vector<Patch> patches_of(const TagFamily& family, int count, const PatchSpec& spec) {
  Random random(9090);
  std::vector<Patch> patches;
  for (int i = 0; i < count; ++i) {
    patches.push_back(tag_patch(family, static_cast<std::size_t>(i), spec, random));
  }
  return patches;
}

// How far found corners lie from the truth.
struct Offsets {
  int tags = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double outwards = 0;  // mean along the diagonal
  double rms = 0;       // per coordinate
};

// Picture i shows tag i.
Offsets offsets_of(const std::vector<DetectedPicture>& result, const std::vector<Patch>& patches) {
  Offsets offsets;
  int n = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const auto& corners = patches[i].corners;
    const Eigen::Vector2d centre = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
    for (const Observation& seen : result[i].view.observations) {
      EXPECT_EQ(seen.id.tag_id, static_cast<int>(i));
      const Eigen::Vector2d& truth = corners[static_cast<std::size_t>(seen.id.corner)];
      const Eigen::Vector2d error = seen.pixel - truth;
      offsets.mean += error;
      offsets.outwards += error.dot((truth - centre).normalized());
      offsets.rms += error.squaredNorm();
      ++n;
    }
  }
  offsets.tags = n / 4;
  offsets.mean /= n;
  offsets.outwards /= n;
  offsets.rms = std::sqrt(offsets.rms / (2 * n));
  return offsets;
}

Offsets measured(const std::string& family, int border_bits, int count, const PatchSpec& spec,
                 const DetectOptions& options = {}) {
  const auto patches = patches_of(tag_family(family, border_bits), count, spec);
  const auto boards = spec.corner_squares ? kalibr_tags(count)
                                          : std::vector{board_of(family, border_bits, 0, count)};
  const auto result = detect_all(sources_of(patches), boards, options);
  const Offsets offsets = offsets_of(result, patches);
  std::printf("%s border %d, %3.0f px: %d of %d tags, mean %+.4f %+.4f, outwards %+.4f, rms %.4f\n",
              family.c_str(), border_bits, spec.side_px, offsets.tags, count, offsets.mean.x(),
              offsets.mean.y(), offsets.outwards, offsets.rms);
  return offsets;
}

TEST(Detector, CornersAreUnbiased) {
  for (const double side : {40.0, 60.0, 100.0}) {
    PatchSpec spec;
    spec.side_px = side;
    const int count = side > 80 ? 12 : 24;  // large ones are slow to draw
    const Offsets offsets = measured("tag36h11", 1, count, spec);
    EXPECT_EQ(offsets.tags, count);
    EXPECT_LT(offsets.mean.cwiseAbs().maxCoeff(), 0.01);
    EXPECT_LT(std::abs(offsets.outwards), 0.01);
    EXPECT_LT(offsets.rms, 0.02);
  }
}

// AprilTag counts the first pixel from 0 to 1, so its corners are moved by half a pixel.
TEST(Detector, CornersOfEachRefinementLieWhereTheTagIs) {
  PatchSpec spec;
  spec.side_px = 60;
  for (const Refinement refinement : {Refinement::stock, Refinement::edges, Refinement::fit}) {
    DetectOptions options;
    options.refinement = refinement;
    const Offsets offsets = measured("tag36h11", 1, 48, spec, options);
    EXPECT_EQ(offsets.tags, 48);
    EXPECT_LT(offsets.mean.cwiseAbs().maxCoeff(), 0.03);
    EXPECT_LT(offsets.rms, refinement == Refinement::stock ? 0.1 : 0.03);
  }
}

TEST(Detector, SmallTagsAreFound) {
  PatchSpec spec;
  spec.side_px = 30;
  const Offsets at_30 = measured("tag36h11", 1, 30, spec);
  EXPECT_EQ(at_30.tags, 30);
  EXPECT_LT(at_30.mean.cwiseAbs().maxCoeff(), 0.02);
  EXPECT_LT(at_30.rms, 0.05);
  spec.side_px = 20;
  const Offsets at_20 = measured("tag36h11", 1, 30, spec);
  EXPECT_GE(at_20.tags, 27);
  EXPECT_LT(at_20.mean.cwiseAbs().maxCoeff(), 0.05);
  EXPECT_LT(at_20.rms, 0.15);
}

TEST(Detector, OtherFamilies) {
  for (const std::string& family : tag_family_names()) {
    const Offsets offsets = measured(family, 1, 8, PatchSpec());
    EXPECT_EQ(offsets.tags, 8) << family;
    EXPECT_LT(offsets.mean.cwiseAbs().maxCoeff(), 0.01) << family;
    EXPECT_LT(offsets.rms, 0.03) << family;
  }
}

TEST(Detector, TagsOfKalibrBoards) {
  PatchSpec spec;
  spec.side_px = 60;
  spec.corner_squares = true;
  const Offsets offsets = measured("tag36h11", 2, 20, spec);
  EXPECT_GE(offsets.tags, 18);
  EXPECT_LT(offsets.mean.cwiseAbs().maxCoeff(), 0.01);
  EXPECT_LT(std::abs(offsets.outwards), 0.01);
  EXPECT_LT(offsets.rms, 0.02);
}

void paste(const Image8& from, int x0, int y0, Image8& to) {
  for (int y = 0; y < from.height(); ++y) {
    std::copy_n(from.row(y), from.width(), to.row(y + y0) + x0);
  }
}

// One picture with tag 3 of 36h11 at the left, and tag 5 of another family at the right.
struct TwoBoards {
  TwoBoards() : image({260, 130}, 200) {
    Random random(4);
    left = tag_patch(tag_family("tag36h11", 1), 3, PatchSpec(), random);
    right = tag_patch(tag_family("tag25h9", 2), 5, PatchSpec(), random);
    paste(left.image, 10, 10, image);
    paste(right.image, 140, 10, image);
  }
  Patch left;
  Patch right;
  Image8 image;
};

TEST(Detector, TwoBoardsInOnePicture) {
  const TwoBoards scene;
  const std::vector<PlacedBoard> boards = {board_of("tag25h9", 2, 5, 2),
                                           board_of("tag36h11", 1, 0, 5)};
  const DetectedPicture found = detect(scene.image, boards, {}, "two.png");
  const View& view = found.view;
  EXPECT_TRUE(found.warnings.empty());
  EXPECT_EQ(view.image, "two.png");
  ASSERT_EQ(view.observations.size(), 8u);
  for (int i = 0; i < 8; ++i) {
    const Observation& seen = view.observations[static_cast<std::size_t>(i)];
    EXPECT_EQ(seen.id, (CornerId{i < 4 ? 3 : 5, i % 4}));
    const Patch& patch = i < 4 ? scene.left : scene.right;
    const Eigen::Vector2d truth =
        patch.corners[static_cast<std::size_t>(i % 4)] + Eigen::Vector2d(i < 4 ? 10 : 140, 10);
    EXPECT_LT((seen.pixel - truth).norm(), 0.06);
  }
}

TEST(Detector, StrangeAndRepeatedTagsAreLeftOut) {
  const TwoBoards scene;
  DetectedPicture found = detect(scene.image, {board_of("tag36h11", 1, 10, 5)}, {}, "a.png");
  EXPECT_TRUE(found.view.observations.empty());
  ASSERT_EQ(found.warnings.size(), 2u);
  EXPECT_EQ(found.warnings[0], "a.png: tag36h11 tags on no board are not reported: 3");
  EXPECT_EQ(found.warnings[1], "a.png: no tag of the boards found");

  Image8 twice({260, 130}, 200);
  paste(scene.left.image, 10, 10, twice);
  paste(scene.left.image, 140, 10, twice);
  found = detect(twice, {board_of("tag36h11", 1, 0, 5)}, {}, "b.png");
  EXPECT_TRUE(found.view.observations.empty());
  ASSERT_EQ(found.warnings.size(), 2u);
  EXPECT_EQ(found.warnings[0], "b.png: tag36h11 tags seen more than once are not reported: 3");
}

// A tag whose corner lies on the picture's edge may be a cut one.
TEST(Detector, TagsAtTheEdgeOfThePictureAreLeftOut) {
  Random random(8);
  PatchSpec spec;
  spec.max_tilt_rad = 0;
  const Patch patch = tag_patch(tag_family("tag36h11", 1), 0, spec, random);
  double left = 1e9;
  for (const Eigen::Vector2d& corner : patch.corners) left = std::min(left, corner.x());
  const auto found_with_margin = [&](int margin) {
    const int skip = static_cast<int>(std::floor(left)) - margin;
    Image8 image({patch.image.width() - skip, patch.image.height()});
    for (int y = 0; y < image.height(); ++y) {
      std::copy_n(patch.image.row(y) + skip, image.width(), image.row(y));
    }
    return !detect(image, {board_of("tag36h11", 1, 0, 1)}).view.observations.empty();
  };
  EXPECT_TRUE(found_with_margin(6));
  EXPECT_FALSE(found_with_margin(0));
}

TEST(Detector, WhatIsLeftOfATagThatTheEdgeCutsIsNoTag) {
  Random random(9);
  int found = 0;
  PatchSpec spec;
  spec.side_px = 90;
  for (int i = 0; i < 20; ++i) {
    const Patch patch = tag_patch(tag_family("tag36h11", 1), 0, spec, random);
    double left = 1e9;
    for (const Eigen::Vector2d& corner : patch.corners) left = std::min(left, corner.x());
    for (int cut = -6; cut <= 4; ++cut) {
      const int skip = static_cast<int>(std::floor(left)) + cut;
      if (skip < 0) continue;
      Image8 image({patch.image.width() - skip, patch.image.height()});
      for (int y = 0; y < image.height(); ++y)
        std::copy_n(patch.image.row(y) + skip, image.width(), image.row(y));
      const View view = detect(image, {board_of("tag36h11", 1, 0, 1)}).view;
      found += !view.observations.empty();
      for (const Observation& o : view.observations) {
        const Eigen::Vector2d truth =
            patch.corners[static_cast<std::size_t>(o.id.corner)] - Eigen::Vector2d(skip, 0);
        EXPECT_LT((o.pixel - truth).norm(), 0.5)
            << "cut by " << cut << " px: " << o.pixel.transpose() << " for " << truth.transpose();
      }
    }
  }
  EXPECT_GT(found, 40);
}

TEST(Detector, ThreadsDoNotChangeTheAnswer) {
  auto patches = patches_of(tag_family("tag36h11", 2), 12, {});
  patches[4].image = Image8({3, 3});
  const std::vector<PlacedBoard> boards = {board_of("tag36h11", 2, 2, 8)};
  DetectOptions options;
  options.threads = 1;
  const std::vector<DetectedPicture> one = detect_all(sources_of(patches), boards, options);
  EXPECT_EQ(one[3].view.observations.size(), 4u);
  EXPECT_TRUE(one[4].view.observations.empty());
  for (const int threads : {2, 5, 0}) {
    options.threads = threads;
    int calls = 0;
    int last = 0;
    const std::vector<DetectedPicture> many =
        detect_all(sources_of(patches), boards, options, [&](int done, int total) {
          ++calls;
          EXPECT_EQ(done, last + 1);
          last = done;
          EXPECT_EQ(total, 12);
        });
    EXPECT_EQ(calls, 12);
    ASSERT_EQ(many.size(), one.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      const auto& a = one[i].view.observations;
      const auto& b = many[i].view.observations;
      EXPECT_EQ(many[i].view.image, one[i].view.image);
      EXPECT_EQ(many[i].warnings, one[i].warnings);
      EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end(),
                             [](const Observation& p, const Observation& q) {
                               return p.id == q.id && p.pixel == q.pixel;
                             }));
    }
  }
}

TEST(Detector, AnErrorOfAPictureIsTheFirstOne) {
  std::vector<ImageSource> sources;
  for (int i = 0; i < 12; ++i) {
    sources.push_back({std::to_string(i), [i]() -> Image8 {
                         if (i == 5 || i == 6 || i == 9) throw Error(std::to_string(i) + " is bad");
                         return Image8({16, 16});
                       }});
  }
  for (const int threads : {1, 2, 4}) {
    DetectOptions options;
    options.threads = threads;
    EXPECT_ERROR(detect_all(sources, {board_of("tag36h11", 1, 0, 5)}, options), "5 is bad");
  }
  EXPECT_THROW(detect_all({}, {board_of("tag99", 1, 0, 5)}, {}), Error);
  EXPECT_TRUE(detect_all({}, {board_of("tag36h11", 1, 0, 5)}, {}).empty());
}

enum class Filling { black, white, noise, checker };

Image8 filled(const ImageSize& size, Filling filling) {
  Random random(1);
  Image8 image(size, filling == Filling::white ? 255 : 0);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      if (filling == Filling::noise) image(x, y) = static_cast<std::uint8_t>(random.index(256));
      if (filling == Filling::checker) image(x, y) = (x + y) % 2 ? 255 : 0;
    }
  }
  return image;
}

TEST(Detector, SmallAndEmptyPicturesHoldNothing) {
  std::vector<ImageSource> sources;
  const auto add = [&](ImageSize size, Filling filling) {
    sources.push_back({"x", [size, filling] { return filled(size, filling); }});
  };
  for (const Filling filling : {Filling::black, Filling::white, Filling::noise, Filling::checker}) {
    for (int height = 0; height <= 16; ++height) {
      for (int width = 0; width <= 16; ++width) add({width, height}, filling);
    }
    for (const int length : {17, 100, 1000}) {
      add({1, length}, filling);
      add({length, 1}, filling);
      add({8, length}, filling);
      add({length, 8}, filling);
    }
    add({200, 150}, filling);
  }
  const std::vector<DetectedPicture> result =
      detect_all(sources, {board_of("tag36h11", 2, 0, 587), board_of("tag25h9", 1, 0, 35)}, {});
  for (const DetectedPicture& picture : result) {
    EXPECT_TRUE(picture.view.observations.empty());
    EXPECT_FALSE(picture.warnings.empty());  // each says why
  }
}

// AprilTag ends the program at 32768 px; tags of such a picture are found at half its size.
TEST(Detector, PicturesMayBeWiderThanAprilTagTakes) {
  const std::vector<PlacedBoard> boards = {{make_board(AprilGrid{2, 2, 0.1, 0.3}), {}}};
  for (const ImageSize& size : {ImageSize{32768, 100}, ImageSize{100, 40000}}) {
    const DetectedPicture found = detect(Image8(size, 200), boards, {}, "wide.png");
    EXPECT_TRUE(found.view.observations.empty());
    EXPECT_TRUE(std::ranges::any_of(found.warnings, [](const std::string& warning) {
      return warning.find("wider or higher than 32767 pixels") != std::string::npos;
    }));
  }
}

TEST(Detector, TagsThatTheirFamilyDoesNotHaveAreAnError) {
  const std::vector<PlacedBoard> boards = {{make_board(AprilGrid{30, 20, 0.1, 0.3}), {}}};
  EXPECT_ERROR(detect(Image8({100, 100}, 200), boards, {}, "a.png"),
               "board: tag id: must be in 0..586 of tag36h11, got 587");
}

TEST(Detector, NoBoardsNoTags) {
  const TwoBoards scene;
  EXPECT_TRUE(detect(scene.image, {}).view.observations.empty());
}

// Photographs that are not part of the project.
TEST(Detector, RealPhotographs) {
  const std::filesystem::path source = TAGCAL_SOURCE_DIR;
  const bool beside = std::filesystem::exists(source / "../shared/real");
  const auto folder = source / (beside ? "../shared/real" : "../../shared/real");
  if (!std::filesystem::exists(folder / "two_boards.png")) {
    GTEST_SKIP() << "no photographs beside the project";
  }
  const Image8 image = read_image(folder / "two_boards.png");
  const DetectedPicture found = detect(image, kalibr_tags(72), {}, "two");
  EXPECT_GE(found.view.observations.size(), 4 * 60u);
  EXPECT_TRUE(found.warnings.empty());
}

}  // namespace
}  // namespace tagcal
