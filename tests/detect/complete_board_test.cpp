#include "tagcal/detect/board_search/complete_board.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <numbers>

#include "false_tag_pictures.hpp"
#include "tagcal/detect/board_search/board_patterns.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal {
using namespace internal;
namespace {

const Lens kFisheye = Fisheye({300, 300, 319.5, 239.5, -0.01, 0.002, 0, 0});
const Lens kPinhole = pinhole(600, 600, 319.5, 239.5);

// A board 0.5 m before a camera, tilted about its middle, with the corners where they truly are.
class Sight {
 public:
  explicit Sight(const Board& shown, const Lens& lens = kPinhole, double tilt_rad = 0.6,
                 const Eigen::Vector3d& middle_in_camera = {0, 0, 0.65})
      : board(shown) {
    scene_.camera = {lens, {640, 480}};
    scene_.boards = {{board, Pose()}};
    scene_.sensor = {1, 0.7, 2};
    const Eigen::Quaterniond facing(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
    const Eigen::Quaterniond tilt(
        Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d(0.5, 1, 0.2).normalized()));
    const auto points = target_points(board);
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const TargetPoint& p : points) middle += p.position / static_cast<double>(points.size());
    const Eigen::Quaterniond rotation = tilt * facing;
    camera_from_board_ = Pose(rotation, middle_in_camera - rotation * middle);
  }

  // Grey paper over a tag, a millimetre above it, `share` of its side from its lower-left corner.
  void hide(int tag_id, double share = 1) {
    for (const Tag& tag : board.tags) {
      if (tag.id != tag_id) continue;
      const auto c = tag_corners(tag);
      const Eigen::Vector3d up(0, 0, 1e-3);
      const Eigen::Vector3d right = share * (c[1] - c[0]), along = share * (c[3] - c[0]);
      scene_.occluders.push_back(
          {{c[0] + up, c[0] + right + up, c[0] + right + along + up, c[0] + along + up}, 0.5});
    }
  }

  Image8 image() const {
    const TagFamilies families = {{board.family, tag_family(board.family, board.border_bits)}};
    return expose(render_light(scene_, families, camera_from_board_), scene_.sensor, 7);
  }

  // The corners of a tag, in the picture or out of it.
  Quad truth(int tag_id) const {
    Quad quad;
    for (const Tag& tag : board.tags) {
      if (tag.id != tag_id) continue;
      const auto corners = tag_corners(tag);
      for (std::size_t i = 0; i < 4; ++i)
        quad[i] = *project(scene_.camera.lens, camera_from_board_ * corners[i]);
    }
    return quad;
  }

  FoundTag seed(int tag_id) const { return {tag_id, truth(tag_id), true}; }

  Board board;

 private:
  Scene scene_;
  Pose camera_from_board_;
};

Board kalibr_board(int first_id = 0) { return grid_board({6, 5, 0.06, 0.3, first_id}); }

// Completes with the refinement that the detector has if no fit under the picture's lens follows.
Completion completed(const Sight& sight, const Image8& image, const std::vector<FoundTag>& found,
                     const Board& board) {
  FamilyDetector detector({board.family,
                           board.border_bits,
                           {},
                           board.corner_squares,
                           board_patterns({{board, Pose()}})},
                          {});
  const CompletionRules rules{
      1, {}, [&](int id, const Quad& start) { return detector.refined(image, id, start, false); }};
  const TagFamily family = tag_family(board.family, board.border_bits);
  Completion completion = complete_board(image, board, family, found, rules);
  for (const FoundTag& tag : completion.tags) {
    const Quad truth = sight.truth(tag.id);
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_LT((tag.corners[i] - truth[i]).norm(), 0.25) << "tag " << tag.id;
  }
  return completion;
}

Completion completed(const Sight& sight, const std::vector<FoundTag>& found) {
  return completed(sight, sight.image(), found, sight.board);
}

std::map<int, WhyNot> reasons(const Completion& completion) {
  std::map<int, WhyNot> why;
  for (const MissingTag& tag : completion.missing) why[tag.id] = tag.why;
  return why;
}

// For messages.
std::string missing(const Completion& completion) {
  std::string text;
  for (const MissingTag& tag : completion.missing) {
    text += std::to_string(tag.id) + ": " + std::string(why_not_text(tag.why));
    if (tag.expected) {
      const Eigen::Vector2d at = ((*tag.expected)[0] + (*tag.expected)[2]) / 2;
      text += " at " + std::to_string(at.x()) + " " + std::to_string(at.y());
    }
    text += "\n";
  }
  return text;
}

TEST(CompleteBoard, OneTagLeadsToAllOthersThroughAFisheye) {
  for (const Eigen::Vector3d& middle :
       {Eigen::Vector3d(0, 0, 0.3), Eigen::Vector3d(0.06, 0.03, 0.27)}) {
    const Sight sight(kalibr_board(), kFisheye, 0.4, middle);
    for (const int seed : {0, 14, 29}) {
      const Completion completion = completed(sight, {sight.seed(seed)});
      EXPECT_EQ(completion.tags.size(), 30u) << "from tag " << seed << "\n" << missing(completion);
      EXPECT_EQ(completion.added.size(), 29u);
    }
  }
}

TEST(CompleteBoard, PlainBoardsOfAnyFamily) {
  for (const std::string& family : tag_family_names()) {
    const double gap = tag_family(family, 1).reversed_border ? 1.3 : 0.3;
    const Sight sight(grid_board({5, 4, 0.04, gap, 3}, family, 1, false));
    const Completion completion = completed(sight, {sight.seed(3)});
    EXPECT_EQ(completion.tags.size(), 20u) << family << "\n" << missing(completion);
  }
}

TEST(CompleteBoard, TagsThatAreNotInSightAreNotReported) {
  Sight sight(kalibr_board());
  sight.hide(8);
  sight.hide(21, 0.6);
  const Completion completion = completed(sight, {sight.seed(0), sight.seed(29)});
  EXPECT_EQ(completion.tags.size(), 28u);
  const auto why = reasons(completion);
  ASSERT_EQ(why.size(), 2u) << missing(completion);
  EXPECT_EQ(why.at(8), WhyNot::other_bits);
  EXPECT_EQ(why.at(21), WhyNot::other_bits);
}

// The target says ids 0 to 29; the picture shows 100 to 129, so that only borders answer.
TEST(CompleteBoard, OtherTagsInTheSamePlacesAreNotReported) {
  const Sight other(kalibr_board(100));
  const Image8 image = other.image();
  for (const int seed : {0, 14, 29}) {
    Quad corners = other.truth(100 + seed);
    const Completion completion = completed(other, image, {{seed, corners, true}}, kalibr_board());
    EXPECT_TRUE(completion.tags.empty());
    ASSERT_EQ(completion.missing.size(), 30u);
    EXPECT_EQ(reasons(completion).at(seed), WhyNot::other_bits);
  }
}

// A whole row of tags further on would also fit where one is off by a row.
TEST(CompleteBoard, ASeedThatIsNotThereLeadsNowhere) {
  const Sight sight(kalibr_board());
  const FoundTag wrong{7, sight.truth(14), true};
  const Completion completion = completed(sight, {wrong});
  EXPECT_TRUE(completion.tags.empty());
  const auto why = reasons(completion);
  EXPECT_EQ(why.at(7), WhyNot::other_bits);
  EXPECT_EQ(why.at(0), WhyNot::no_neighbour);
}

TEST(CompleteBoard, ASeedThatWentAstrayIsSetRight) {
  const Sight sight(kalibr_board());
  FoundTag seed = sight.seed(14);
  const Eigen::Vector2d cell = (seed.corners[1] - seed.corners[0]) / 10;
  seed.corners[0] += 0.9 * cell;
  seed.corners[3] += 0.8 * cell;
  const Completion completion = completed(sight, {seed});
  EXPECT_EQ(completion.tags.size(), 30u) << missing(completion);
}

TEST(CompleteBoard, TagsCutByThePicturesEdgeAreLeftOut) {
  const Sight sight(kalibr_board(), kPinhole, 0.5, {-0.25, 0.1, 0.5});
  const Completion completion = completed(sight, {sight.seed(16)});
  int inside = 0;
  for (const Tag& tag : sight.board.tags) {
    const Quad truth = sight.truth(tag.id);
    bool whole = true;
    for (const Eigen::Vector2d& c : truth)
      whole &= c.minCoeff() > 1.2 && c.x() < 639 - 1.2 && c.y() < 479 - 1.2;
    inside += whole;
  }
  EXPECT_GT(inside, 8);
  EXPECT_LT(inside, 25);
  EXPECT_EQ(completion.tags.size(), static_cast<std::size_t>(inside));
  for (const MissingTag& tag : completion.missing) EXPECT_EQ(tag.why, WhyNot::outside) << tag.id;
}

TEST(CompleteBoard, SmallAndTurnedTags) {
  for (const double distance : {0.9, 1.3, 1.7}) {
    const Sight sight(kalibr_board(), kPinhole, 0.4, {0.1, 0.05, distance});
    const Completion completion = completed(sight, {sight.seed(14), sight.seed(15)});
    EXPECT_EQ(completion.tags.size(), 30u) << 36 / distance << " px";
  }
}

TEST(CompleteBoard, IdsLeftOutAndIdsBeyondTheFamily) {
  const Sight sight(grid_board({5, 4, 0.04, 0.3, 0}, "tag25h9", 2, true));
  const Image8 image = sight.image();
  FamilyDetector detector({"tag25h9", 2, {}, true, {}}, {});
  const CompletionRules rules{
      1, {6, 7}, [&](int id, const Quad& start) { return detector.refined(image, id, start); }};
  const TagFamily family = tag_family("tag25h9", 2);
  EXPECT_EQ(complete_board(image, sight.board, family, {sight.seed(0)}, rules).tags.size(), 18u);
  Board beyond = sight.board;
  beyond.tags[19].id = 35;  // of 0 to 34
  const Completion completion = complete_board(image, beyond, family, {sight.seed(0)}, rules);
  EXPECT_EQ(reasons(completion).at(35), WhyNot::other_bits);
  EXPECT_EQ(completion.tags.size(), 17u);
}

TEST(CompleteBoard, NothingFromNothing) {
  const Sight sight(kalibr_board());
  const Completion completion = completed(sight, {});
  EXPECT_TRUE(completion.tags.empty());
  ASSERT_EQ(completion.missing.size(), 30u);
  for (const MissingTag& tag : completion.missing) EXPECT_EQ(tag.why, WhyNot::no_neighbour);
  EXPECT_TRUE(
      complete_board(sight.image(), Board(), tag_family("tag36h11", 2), {}, {}).tags.empty());
}

// Four times four bits are soon read by chance: one tag of a board in full sight is no tag.
TEST(CompleteBoard, ALoneTagOfASmallFamilyIsNotBelieved) {
  const Board board = grid_board({5, 4, 0.04, 0.5, 0}, "tag16h5", 1, false);
  Sight sight(board);
  EXPECT_EQ(completed(sight, {sight.seed(7)}).tags.size(), 20u);
  for (const Tag& tag : board.tags)
    if (tag.id != 7 && tag.id != 8) sight.hide(tag.id);
  EXPECT_EQ(completed(sight, {sight.seed(7)}).tags.size(), 2u);
  sight.hide(8);
  const Completion alone = completed(sight, {sight.seed(7)});
  EXPECT_TRUE(alone.tags.empty());
  EXPECT_EQ(reasons(alone).at(7), WhyNot::alone);
  // A target of this tag only has nothing beside it to ask.
  Board single = board;
  single.grid.reset();
  single.tags = {board.tags[7]};
  EXPECT_EQ(completed(sight, sight.image(), {sight.seed(7)}, single).tags.size(), 1u);
  // A large family is believed.
  Sight large(kalibr_board());
  for (const Tag& tag : large.board.tags)
    if (tag.id != 7) large.hide(tag.id);
  EXPECT_EQ(completed(large, {large.seed(7)}).tags.size(), 1u);
}

// studies/false_tags.cpp looks at more.
TEST(CompleteBoard, NoTagsInPicturesWithoutTags) {
  std::vector<ImageSource> images;
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
    images.push_back({std::to_string(seed), [seed] { return picture_without_tags(seed); }});
  for (const Board& board : {kalibr_board(), grid_board({6, 6, 0.04, 1, 0}, "tag36h11", 1, false),
                             grid_board({5, 5, 0.04, 1, 0}, "tag25h9", 1, false),
                             grid_board({6, 5, 0.04, 1.2, 0}, "tag16h5", 1, false)}) {
    for (const View& view : detect_all(images, {{board, Pose()}}, {}).views)
      EXPECT_TRUE(view.observations.empty()) << view.image;
  }
}

// Photographs that are not part of the project.
TEST(CompleteBoard, RealPhotographs) {
  const std::filesystem::path source = TAGCAL_SOURCE_DIR;
  const bool beside = std::filesystem::exists(source / "../shared/real");
  const auto folder = source / (beside ? "../shared/real" : "../../shared/real");
  if (!std::filesystem::exists(folder / "004.jpg")) {
    GTEST_SKIP() << "no photographs beside the project";
  }
  const PlacedBoard board{grid_board({6, 6, 0.088, 0.3, 0}), Pose()};
  const PlacedBoard second{grid_board({6, 6, 0.088, 0.3, 36}), Pose()};
  const auto found = [&](const char* name, const std::vector<PlacedBoard>& boards) {
    return detect(read_image(folder / name), name, boards, {}, nullptr).observations.size() / 4;
  };
  EXPECT_EQ(found("000.jpg", {board}), 36u);
  EXPECT_EQ(found("004.jpg", {board}), 21u);  // all that are whole
  EXPECT_EQ(found("two_boards.png", {board, second}), 72u);
}

}  // namespace
}  // namespace tagcal
