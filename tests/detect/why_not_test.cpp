// The reasons why a tag of a board is not reported, each caused on purpose; no_neighbour, outside,
// other_bits and alone: complete_board_test.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <optional>

#include "board_sight.hpp"
#include "tagcal/detect/board_search/tag_search.hpp"
#include "tagcal/random.hpp"

namespace tagcal {
using namespace internal;
namespace {

// Changes the pixels in a box around a tag, with most of the gap to its neighbours.
void repaint(Image8& image, const Quad& tag, const std::function<std::uint8_t(std::uint8_t)>& to) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& corner : tag) box.extend(corner);
  const Eigen::Array2i margin = (0.6 * box.sizes().array()).cast<int>();
  const Eigen::Array2i low = box.min().array().cast<int>() - margin;
  const Eigen::Array2i high = box.max().array().cast<int>() + margin;
  for (int y = low.y(); y <= high.y(); ++y)
    for (int x = low.x(); x <= high.x(); ++x) image(x, y) = to(image(x, y));
}

TEST(WhyNot, FlatAndInvertedPlacesAreNamed) {
  const BoardSight sight(make_board(AprilGrid{5, 4, 0.04, 0.8, 0, "tag36h11", 1, false}), kPinhole,
                         0.1);
  Image8 image = sight.image();
  repaint(image, sight.truth(8), [](std::uint8_t) { return 128; });
  repaint(image, sight.truth(14), [](std::uint8_t level) { return 255 - level; });
  const Completion completion = completed(sight, image, {sight.seed(0)}, sight.board);
  const auto why = reasons(completion);
  ASSERT_EQ(why.size(), 2u) << missing(completion);
  EXPECT_EQ(why.at(8), WhyNot::no_contrast);
  EXPECT_EQ(why.at(14), WhyNot::no_border);
}

TEST(WhyNot, TagsOfTooFewPixelsAreNamed) {
  Tags board{"tag36h11", 1, tags_of(make_board(AprilGrid{2, 1, 0.06, 1}))};
  board.tags[1].size = 0.006;
  const BoardSight sight(make_board(board));
  const auto why = reasons(completed(sight, {sight.seed(0)}));
  ASSERT_EQ(why.size(), 1u);
  EXPECT_EQ(why.at(1), WhyNot::too_small);
}

TEST(WhyNot, EdgesThatCannotBeFittedAreNamed) {
  const BoardSight sight(kalibr_board());
  const Image8 image = sight.image();
  const CompletionRules rules{
      1, {}, [&](int id, const Quad& start) {
        return id == 8 ? std::nullopt : std::optional(FoundTag{id, start, true});
      }};
  const auto why = reasons(
      complete_board(image, sight.board, tag_family("tag36h11", 2), {sight.seed(0)}, rules));
  ASSERT_EQ(why.size(), 1u);
  EXPECT_EQ(why.at(8), WhyNot::no_edges);
}

// The cells are right, but every pixel is off by much.
TEST(WhyNot, TagsWhosePatternCannotBeFittedAreNamed) {
  const BoardSight sight(make_board(AprilGrid{5, 4, 0.04, 0.8, 0, "tag36h11", 1, false}), kPinhole,
                         0.1);
  Image8 image = sight.image();
  Random random(1);
  repaint(image, sight.truth(8), [&](std::uint8_t level) {
    return static_cast<std::uint8_t>(std::clamp(level + random.uniform(-80, 80), 0.0, 255.0));
  });
  const SeenTags seen = TagSearch({&sight.board}, {}).find(image);
  const auto why = reasons(seen.completions.at(0));
  ASSERT_EQ(why.size(), 1u);
  EXPECT_EQ(why.at(8), WhyNot::no_fit);
}

}  // namespace
}  // namespace tagcal
