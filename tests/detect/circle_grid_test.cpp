#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>

#include "expect.hpp"
#include "rendered_checkerboard.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/explain.hpp"
#include "tagcal/detect/opencv/circle_blobs.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;

// Half fields of view of 31 degrees under a barrel, and of 70 degrees.
Camera strong_lens(int i) {
  const Lens lenses[] = {Perspective({530, 530, 322, 238, -.4, .18}),
                         Fisheye({270, 270, 322, 238, -.02, .004, -.002, 0})};
  return {lenses[i % 2], {640, 480}};
}

Board circles(int columns, int rows, bool asymmetric, double share = 0.5) {
  CircleGrid grid{columns, rows, .02, 0, asymmetric, 0};
  grid.diameter = share * centre_distance(grid);
  return make_board(grid);
}

DetectedPicture found_discs(const CheckerView& view, const Camera* camera = nullptr) {
  DetectOptions options;
  options.camera = camera;
  return detect(view.image, {{view.board, Pose()}}, options, "a.png");
}

// Errors of centres, those of each picture in its own claims.
struct CentreErrors {
  int count = 0;
  double nees = 0, squares = 0, claimed = 0;
  Vector2d mean = Vector2d::Zero();  // in standard deviations, towards the picture's middle, across

  void add(const View& seen, const CheckerView& view) {
    const Vector2d middle(view.camera.image_size.width / 2.0, view.camera.image_size.height / 2.0);
    for (const Observation& one : seen.observations) {
      const Vector2d truth = view.corners.at(one.id), error = one.pixel - truth;
      nees += error.dot(one.covariance_px2->inverse() * error) / 2;
      squares += error.squaredNorm();
      claimed += one.covariance_px2->trace();
      const Vector2d inwards = (middle - truth).normalized();
      const double sd = std::sqrt(one.covariance_px2->trace() / 2);
      mean += Vector2d(inwards.dot(error), inwards.x() * error.y() - inwards.y() * error.x()) / sd;
      ++count;
    }
  }
};

const Board kAsymmetric = circles(4, 9, true), kSymmetric = circles(8, 6, false);

// Under a strong lens up to 60 degrees, the lens unknown and known. The bound is the covariance of
// a fit under the true lens to the picture with more noise, scaled to its noise and rounding: with
// next to none the misfit of the model counts.
TEST(CircleGrids, CentresAreAtTheBoundUpTo60Degrees) {
  for (const double tilt : {0.0, 30.0, 45.0, 60.0}) {
    Random random(7);
    CentreErrors unknown, known, loud, blobs;
    for (int i = 0; i < 8; ++i) {
      CheckerViewSpec spec{random.uniform(18, 34), tilt, .8, 2, random.uniform(-1, 1)};
      Random again = random;
      const Board& board = i / 2 % 2 == 0 ? kAsymmetric : kSymmetric;
      const CheckerView view = checker_view(board, strong_lens(i), spec, random);
      ASSERT_TRUE(view.is_whole);
      const View seen = found_discs(view).view;
      ASSERT_EQ(seen.observations.size(), view.corners.size()) << tilt << " " << i;
      unknown.add(seen, view);
      known.add(found_discs(view, &view.camera).view, view);
      spec.noise_levels = 8;
      const CheckerView same = checker_view(view.board, view.camera, spec, again);
      loud.add(found_discs(same, &view.camera).view, same);
      View start = seen;
      const auto gravity = internal::circle_blobs(view.image, 1);
      for (Observation& one : start.observations)
        one.pixel = std::ranges::min_element(gravity, {}, [&](const internal::CircleBlob& blob) {
                      return (blob.at - view.corners.at(one.id)).norm();
                    })->at;
      blobs.add(start, view);
    }
    SCOPED_TRACE(tilt);
    const double bound = loud.claimed * (4 + 1. / 12) / (64 + 1. / 12);
    for (const CentreErrors& errors : {unknown, known}) {
      EXPECT_GT(errors.nees / errors.count, 0.8);
      EXPECT_LT(errors.nees / errors.count, 1.2);
      EXPECT_LT(errors.squares, 1.1 * 1.1 * bound);
      EXPECT_LT((errors.mean / errors.count).norm(), 0.2);
    }
    EXPECT_GT(blobs.squares, 9 * bound);
  }
}

// Without a lens of the picture the claim has what a usual lens may do.
TEST(CircleGrids, FewCirclesClaimNoMoreThanTheyKnow) {
  Random random(8);
  CentreErrors errors;
  for (int i = 0; i < 6; ++i) {
    const CheckerView view = checker_view(circles(5, 4, false), strong_lens(i),
                                          {50, 40, .8, 1, random.uniform(-1, 1)}, random);
    const View seen = found_discs(view).view;
    ASSERT_EQ(seen.observations.size(), 20U);
    errors.add(seen, view);
  }
  EXPECT_LT(errors.nees / errors.count, 1.2);
}

TEST(CircleGrids, LargeDiscsOfLargePicturesAreFitted) {
  Random random(9);
  const Camera camera{Perspective({1500, 1500, 1000, 740, -.3, .1}), {2000, 1500}};
  const CheckerView view = checker_view(kAsymmetric, camera, {110, 40, 1.2, 1, .3}, random);
  const View seen = found_discs(view).view;
  ASSERT_EQ(seen.observations.size(), 36U);
  CentreErrors errors;
  errors.add(seen, view);
  EXPECT_LT(errors.nees / errors.count, 1.5);
  EXPECT_LT(std::sqrt(errors.squares / (2 * errors.count)), 0.01);
}

TEST(CircleGrids, AnOddNumberOfAsymmetricRowsTellsWhichEndIsWhich) {
  Random random(10);
  for (const double roll : {0.0, 1.7, std::numbers::pi}) {
    const CheckerView view =
        checker_view(kAsymmetric, strong_lens(0), {20, 30, .8, 2, roll}, random);
    const DetectedPicture picture = found_discs(view);
    EXPECT_TRUE(board_warnings({{view.board, Pose()}}, {}).empty());
    CentreErrors errors;
    errors.add(picture.view, view);
    EXPECT_EQ(errors.count, 36);
    EXPECT_LT(errors.nees / errors.count, 2);
  }
}

TEST(CircleGrids, BoardsThatLookTheSameAfterATurnAreSaidToBeAmbiguous) {
  Random random(11);
  for (const auto& [board, turn] : {std::pair(circles(4, 8, true), "half a turn"),
                                    {kSymmetric, "half a turn"},
                                    {circles(5, 5, false), "a quarter turn"}}) {
    const CheckerView turned =
        checker_view(board, strong_lens(0), {20, 20, .8, 2, std::numbers::pi + .3}, random);
    const DetectedPicture picture = found_discs(turned);
    const auto warnings = board_warnings({{board, Pose()}}, {});
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_HAS(warnings[0], turn);
    const std::vector<Observation>& seen = picture.view.observations;
    ASSERT_EQ(seen.size(), target_points(board).size());
    EXPECT_LT((seen[0].pixel - turned.corners.rbegin()->second).norm(), 0.3);
  }
}

// Fills a box about a disc with a level.
void hide(CheckerView& view, int id, std::uint8_t level) {
  const Vector2d at = view.corners.at({id, 0});
  for (int y = -8; y <= 8; ++y)
    for (int x = -8; x <= 8; ++x)
      view.image(static_cast<int>(at.x()) + x, static_cast<int>(at.y()) + y) = level;
}

TEST(CircleGrids, SingleDiscsMayBeHiddenButNoOutermostRow) {
  Random random(12);
  CheckerView view = checker_view(kSymmetric, strong_lens(0), {22, 10, .8, 2, .1}, random);
  for (const int id : {0, 11, 28}) hide(view, id, 220);
  const View seen = found_discs(view).view;
  ASSERT_EQ(seen.observations.size(), 45U);
  CentreErrors errors;
  errors.add(seen, view);
  EXPECT_LT(errors.nees / errors.count, 1.5);
  for (int id = 0; id < 8; ++id) hide(view, id, 220);
  const DetectedPicture part = found_discs(view);
  EXPECT_TRUE(part.view.observations.empty());
  ASSERT_EQ(part.warnings.size(), 1U);
  EXPECT_EQ(part.warnings[0], "a.png: the symmetric grid of 8 x 6 circles is not found");
  const Explanation why = explain(view.image, {{view.board, Pose()}});
  ASSERT_EQ(why.checkerboards.size(), 1U);
  EXPECT_EQ(why.checkerboards[0], "the symmetric grid of 8 x 6 circles is not found");
}

TEST(CircleGrids, WrongSizesAndTypesAreNamed) {
  Random random(14);
  const CheckerView view = checker_view(kAsymmetric, strong_lens(0), {22, 20, .8, 2, .2}, random);
  const std::string shows = "the picture shows the asymmetric grid of 4 x 9 circles, but ";
  const std::string write = "write targetCols: 4, targetRows: 9, asymmetricGrid: true";
  const auto mistakes = [&](const Board& board) {
    return explain(view.image, {{board, Pose()}}).mistakes;
  };
  for (const Board& board : {circles(4, 7, true), circles(9, 4, true), circles(4, 9, false)}) {
    const auto named = mistakes(board);
    ASSERT_EQ(named.size(), 1U);
    EXPECT_HAS(named[0], "wrong size of grid: " + shows);
    EXPECT_HAS(named[0], write);
  }
  const auto other = mistakes(make_board(Checkerboard{8, 5, .03, .03}));
  ASSERT_EQ(other.size(), 1U);
  EXPECT_HAS(other[0], "wrong target_type: " + shows);
  EXPECT_HAS(other[0], "write target_type: circlegrid, targetCols: 4, targetRows: 9");
  // A smaller grid may be a part of the board: several pictures tell.
  EXPECT_TRUE(mistakes(circles(5, 9, true)).empty());
  EXPECT_TRUE(mistakes(kAsymmetric).empty());
  const std::vector<ImageSource> images(3, {"a.png", [&] { return view.image; }});
  const std::vector<PlacedBoard> larger = {{circles(5, 9, true), Pose()}};
  const auto of_three = target_mistakes(images, detect_all(images, larger), larger);
  ASSERT_EQ(of_three.size(), 1U);
  EXPECT_HAS(of_three[0].sentence, write);
}

// Discs of many sizes near the nodes of a lattice: some of them are where a small grid has its
// discs.
Image8 scattered_discs(Random& random) {
  Image8 image({400, 320}, 220);
  for (int row = 0; row < 7; ++row) {
    for (int column = 0; column < 9; ++column) {
      const double x = 40 * column + 40 + random.uniform(-15, 15);
      const double y = 40 * row + 40 + random.uniform(-15, 15), radius = random.uniform(6, 12);
      for (int v = static_cast<int>(y) - 14; v <= y + 14; ++v)
        for (int u = static_cast<int>(x) - 14; u <= x + 14; ++u) {
          const double inside = std::clamp(radius - std::hypot(u - x, v - y) + 0.5, 0.0, 1.0);
          image(u, v) = std::min(image(u, v), static_cast<std::uint8_t>(220 - 190 * inside));
        }
    }
  }
  return image;
}

TEST(CircleGrids, ScatteredDiscsAreNoSmallGrid) {
  Random random(15);
  for (int i = 0; i < 40; ++i) {
    const Image8 image = scattered_discs(random);
    for (const Board& board : {circles(4, 3, false), circles(3, 3, false)})
      EXPECT_TRUE(detect(image, {{board, Pose()}}).view.observations.empty()) << i;
  }
}

// Wherever they lie in the picture, and near before a fisheye.
TEST(CircleGrids, SmallGridsAreFound) {
  Random random(16);
  int num_found = 0;
  for (int i = 0; i < 20; ++i) {
    const CheckerView view =
        checker_view(circles(4, 3, false), strong_lens(1), {100, 50, .8, 2, .2}, random);
    Vector2d low = Vector2d::Constant(1e9);
    for (const auto& [id, at] : view.corners) low = low.cwiseMin(at);
    const int x = std::max(0, static_cast<int>(low.x()) - 60);
    const int y = std::max(0, static_cast<int>(low.y()) - 60);
    const ImageView8 whole = view.image;
    const ImageView8 part(whole.row(y) + x, {whole.width() - x, whole.height() - y},
                          whole.stride());
    for (const ImageView8& image : {whole, part})
      num_found += !detect(image, {{view.board, Pose()}}).view.observations.empty();
  }
  EXPECT_GE(num_found, 34);
}

TEST(CircleGrids, OtherPicturesShowNone) {
  Random random(13);
  const CheckerView squares = checker_view(make_board(Checkerboard{8, 5, .03, .03}), strong_lens(0),
                                           {24, 20, .8, 2, .2}, random);
  const CheckerView other = checker_view(kAsymmetric, strong_lens(0), {22, 20, .8, 2, .2}, random);
  Image8 noise({320, 240});
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) noise(x, y) = static_cast<std::uint8_t>(random.next() % 256);
  for (const Image8& image : {squares.image, other.image, noise, Image8({320, 240}, 128)}) {
    const DetectedPicture none = detect(image, {{kSymmetric, Pose()}});
    EXPECT_TRUE(none.view.observations.empty());
    EXPECT_EQ(none.warnings.size(), 1U);
  }
}

}  // namespace
}  // namespace tagcal
