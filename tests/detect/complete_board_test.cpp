#include "tagcal/detect/board_search/complete_board.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "board_sight.hpp"
#include "false_tag_pictures.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal {
using namespace internal;
namespace {

const Lens kFisheye = Fisheye({300, 300, 319.5, 239.5, -0.01, 0.002, 0, 0});

TEST(CompleteBoard, OneTagLeadsToAllOthersThroughAFisheye) {
  for (const Eigen::Vector3d& middle :
       {Eigen::Vector3d(0, 0, 0.3), Eigen::Vector3d(0.06, 0.03, 0.27)}) {
    const BoardSight sight(kalibr_board(), kFisheye, 0.4, middle);
    for (const int seed : {0, 14, 29}) {
      const Completion completion = completed(sight, {sight.seed(seed)});
      EXPECT_EQ(completion.tags.size(), 30u) << "from tag " << seed << "\n" << missing(completion);
    }
  }
}

TEST(CompleteBoard, PlainBoardsOfAnyFamily) {
  for (const std::string& family : tag_family_names()) {
    const double gap = tag_family(family, 1).reversed_border ? 1.3 : 0.3;
    const BoardSight sight(make_board(AprilGrid{5, 4, 0.04, gap, 3, family, 1, false}));
    const Completion completion = completed(sight, {sight.seed(3)});
    EXPECT_EQ(completion.tags.size(), 20u) << family << "\n" << missing(completion);
  }
}

TEST(CompleteBoard, TagsThatAreNotInSightAreNotReported) {
  BoardSight sight(kalibr_board());
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
  const BoardSight other(kalibr_board(100));
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
  const BoardSight sight(kalibr_board());
  const FoundTag wrong{7, sight.truth(14), true};
  const Completion completion = completed(sight, {wrong});
  EXPECT_TRUE(completion.tags.empty());
  const auto why = reasons(completion);
  EXPECT_EQ(why.at(7), WhyNot::other_bits);
  EXPECT_EQ(why.at(0), WhyNot::no_neighbour);
}

TEST(CompleteBoard, ASeedThatWentAstrayIsSetRight) {
  const BoardSight sight(kalibr_board());
  FoundTag seed = sight.seed(14);
  const Eigen::Vector2d cell = (seed.corners[1] - seed.corners[0]) / 10;
  seed.corners[0] += 0.9 * cell;
  seed.corners[3] += 0.8 * cell;
  const Completion completion = completed(sight, {seed});
  EXPECT_EQ(completion.tags.size(), 30u) << missing(completion);
}

TEST(CompleteBoard, TagsCutByThePicturesEdgeAreLeftOut) {
  const BoardSight sight(kalibr_board(), kPinhole, 0.5, {-0.25, 0.1, 0.5});
  const Completion completion = completed(sight, {sight.seed(16)});
  int inside = 0;
  for (const Tag& tag : tags_of(sight.board)) {
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
    const BoardSight sight(kalibr_board(), kPinhole, 0.4, {0.1, 0.05, distance});
    const Completion completion = completed(sight, {sight.seed(14), sight.seed(15)});
    EXPECT_EQ(completion.tags.size(), 30u) << 36 / distance << " px";
  }
}

TEST(CompleteBoard, IdsLeftOutAndIdsBeyondTheFamily) {
  const BoardSight sight(make_board(AprilGrid{5, 4, 0.04, 0.3, 0, "tag25h9", 2, false}));
  const Image8 image = sight.image();
  FamilyDetector detector({"tag25h9", 2, {}, false, {}}, {});
  const CompletionRules rules{
      1, {6, 7}, [&](int id, const Quad& start) { return detector.refined(image, id, start); }};
  const TagFamily family = tag_family("tag25h9", 2);
  EXPECT_EQ(complete_board(image, sight.board, family, {sight.seed(0)}, rules).tags.size(), 18u);
  Tags beyond{"tag25h9", 2, tags_of(sight.board)};
  beyond.tags[19].id = 35;  // of 0 to 34
  const Completion completion =
      complete_board(image, make_board(beyond), family, {sight.seed(0)}, rules);
  EXPECT_EQ(reasons(completion).at(35), WhyNot::other_bits);
  EXPECT_EQ(completion.tags.size(), 17u);
}

TEST(CompleteBoard, NothingFromNothing) {
  const BoardSight sight(kalibr_board());
  const Completion completion = completed(sight, {});
  EXPECT_TRUE(completion.tags.empty());
  ASSERT_EQ(completion.missing.size(), 30u);
  for (const MissingTag& tag : completion.missing) EXPECT_EQ(tag.why, WhyNot::no_neighbour);
  EXPECT_TRUE(
      complete_board(sight.image(), Board(), tag_family("tag36h11", 2), {}, {}).tags.empty());
}

// Four times four bits are soon read by chance: one tag of a board in full sight is no tag.
TEST(CompleteBoard, ALoneTagOfASmallFamilyIsNotBelieved) {
  const Board board = make_board(AprilGrid{5, 4, 0.04, 0.5, 0, "tag16h5", 1, false});
  BoardSight sight(board);
  EXPECT_EQ(completed(sight, {sight.seed(7)}).tags.size(), 20u);
  for (const Tag& tag : tags_of(board))
    if (tag.id != 7 && tag.id != 8) sight.hide(tag.id);
  EXPECT_EQ(completed(sight, {sight.seed(7)}).tags.size(), 2u);
  sight.hide(8);
  const Completion alone = completed(sight, {sight.seed(7)});
  EXPECT_TRUE(alone.tags.empty());
  EXPECT_EQ(reasons(alone).at(7), WhyNot::alone);
  // A target of this tag only has nothing beside it to ask.
  const Board single = make_board(Tags{"tag16h5", 1, {tags_of(board)[7]}});
  EXPECT_EQ(completed(sight, sight.image(), {sight.seed(7)}, single).tags.size(), 1u);
  // A large family is believed.
  BoardSight large(kalibr_board());
  for (const Tag& tag : tags_of(large.board))
    if (tag.id != 7) large.hide(tag.id);
  EXPECT_EQ(completed(large, {large.seed(7)}).tags.size(), 1u);
}

// tagcal-study detect_answers looks at more.
TEST(CompleteBoard, NoTagsInPicturesWithoutTags) {
  std::vector<ImageSource> images;
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
    images.push_back({std::to_string(seed), [seed] { return picture_without_tags(seed); }});
  for (const Board& board :
       {kalibr_board(), make_board(AprilGrid{6, 6, 0.04, 1, 0, "tag36h11", 1, false}),
        make_board(AprilGrid{5, 5, 0.04, 1, 0, "tag25h9", 1, false}),
        make_board(AprilGrid{6, 5, 0.04, 1.2, 0, "tag16h5", 1, false})}) {
    for (const DetectedPicture& picture : detect_all(images, {{board, Pose()}}))
      EXPECT_TRUE(picture.view.observations.empty()) << picture.view.image;
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
  const PlacedBoard board{make_board(AprilGrid{6, 6, 0.088, 0.3, 0}), Pose()};
  const PlacedBoard second{make_board(AprilGrid{6, 6, 0.088, 0.3, 36}), Pose()};
  const auto found = [&](const char* name, const std::vector<PlacedBoard>& boards) {
    return detect(read_image(folder / name), boards, {}, name).view.observations.size() / 4;
  };
  EXPECT_EQ(found("000.jpg", {board}), 36u);
  EXPECT_EQ(found("004.jpg", {board}), 21u);  // all that are whole
  EXPECT_EQ(found("two_boards.png", {board, second}), 72u);
}

}  // namespace
}  // namespace tagcal
