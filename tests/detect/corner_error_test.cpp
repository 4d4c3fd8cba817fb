#include "tagcal/detect/board_search/corner_error.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tagcal/camera/camera.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/refine_views.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

constexpr ImageSize kSharpSize{640, 480};
const Fisheye kLens({300, 300, 322, 238, -.02, .004, 0, 0});

// Views of a grid of tags whose corners claim 0.02 px and are off by `sd_px` more, and by a smooth
// displacement of `bend_px` at the board's edges.
std::vector<View> views(const Board& board, double sd_px, double bend_px) {
  constexpr double kClaimed = 0.02;
  Random random(5);
  std::vector<View> result;
  for (int k = 0; k < 4; ++k) {
    const Pose pose = camera_from_world_looking_at(
        {.4 + random.uniform(-.3, .3), .4 + random.uniform(-.3, .3), .9}, {.4, .4, 0}, {0, 1, 0});
    View& view = result.emplace_back();
    for (const TargetPoint& point : target_points(board)) {
      const auto pixel = kLens.project(pose * point.position);
      if (!pixel) continue;
      const double sd = std::hypot(kClaimed, sd_px), u = point.position.x() / .4 - 1;
      const Vector2d off(sd * random.normal() + bend_px * u * u, sd * random.normal());
      view.observations.push_back(
          {point.id, *pixel + off, kClaimed * kClaimed * Matrix2::Identity()});
    }
  }
  return result;
}

double error_of(std::vector<View>& seen, const Board& board) {
  std::vector<ViewOfSize> sized;
  for (View& view : seen) sized.push_back({&view, kSharpSize});
  return add_corner_error(sized, {{board, Pose()}});
}

const Board kTags =
    make_board(AprilGrid{.columns = 6, .rows = 6, .tag_size = .1, .tag_spacing = .3});
const Board kSquares =
    make_board(Checkerboard{.columns = 9, .rows = 7, .column_spacing = .1, .row_spacing = .1});

TEST(CornerError, IsTheScatterBeyondTheClaims) {
  for (const Board& board : {kTags, kSquares}) {
    std::vector<View> seen = views(board, .1, 0);
    const double error = error_of(seen, board);
    EXPECT_NEAR(error, .1, .012);
    EXPECT_NEAR((*seen[0].observations[3].covariance_px2)(0, 0), .0004 + error * error, 1e-12);
  }
}

TEST(CornerError, IsZeroIfTheClaimsHold) {
  std::vector<View> seen = views(kTags, 0, 0);
  EXPECT_EQ(error_of(seen, kTags), 0);
  EXPECT_EQ((*seen[0].observations[3].covariance_px2)(0, 0), .0004);
}

// Without the error the sum of the variances, 0.1^2 + 0.02^2, is 26 times what is claimed.
TEST(CornerError, MakesTheScatterAsClaimed) {
  for (const Board& board : {kTags, kSquares}) {
    std::vector<View> seen = views(board, .1, 0);
    std::vector<ViewOfSize> sized;
    for (View& view : seen) sized.push_back({&view, kSharpSize});
    const auto mean = [&] {
      const ScatterNees nees = scatter_nees(sized, {{board, Pose()}});
      EXPECT_GT(nees.num_corners, 100);
      return nees.sum / nees.num_corners;
    };
    EXPECT_NEAR(mean(), 26, 6);
    add_corner_error(sized, {{board, Pose()}});
    EXPECT_NEAR(mean(), 1, .2);
  }
}

TEST(CornerError, LeavesOutWhatIsSmooth) {
  std::vector<View> seen = views(kTags, 0, .3);
  EXPECT_LT(error_of(seen, kTags), .03);
}

// Claims of observations that were not refined have the error of their own detection already.
TEST(CornerError, OfRefinedViewsWidensWhatAFitHasPut) {
  Dataset found{kSharpSize, {{kTags, Pose()}}, views(kTags, .1, 0), {}};
  const Matrix2 claimed = found.views[0].observations[0].covariance_px2.value();
  Scene scene;
  scene.camera = {kLens, kSharpSize};
  scene.boards = found.boards;
  scene.sensor = {1, .7, 1};
  const Pose pose = camera_from_world_looking_at({.3, .5, .9}, {.4, .4, 0}, {0, 1, 0});
  Image8 image = expose(render_light(scene, tag_families(scene.boards), pose), scene.sensor, 3);
  View& view = found.views.emplace_back(View{"a.png", visible_corners(scene, pose)});
  for (Observation& seen : view.observations) seen.covariance_px2 = claimed;
  constexpr int kHidden = 14;
  const auto corner = std::ranges::find(view.observations, CornerId{kHidden, 0}, &Observation::id);
  for (int y = -40; y <= 40; ++y)
    for (int x = -40; x <= 40; ++x)
      image(static_cast<int>(corner->pixel.x()) + x, static_cast<int>(corner->pixel.y()) + y) = 128;

  const RefinedViews refined =
      refine_views(found, {{"a.png", [&] { return image; }}}, scene.camera, 1);
  EXPECT_GT(refined.num_refined_tags, 25);
  EXPECT_LT(refined.num_refined_tags, refined.num_tags);
  EXPECT_GT(refined.corner_error_px, .05);
  for (const View& one : refined.views)
    for (const Observation& seen : one.observations)
      if (one.image.empty() || seen.id.tag_id == kHidden) {
        EXPECT_EQ(*seen.covariance_px2, claimed);
      } else if (*seen.covariance_px2 != claimed) {
        EXPECT_GT((*seen.covariance_px2)(0, 0), std::pow(refined.corner_error_px, 2));
      }
}

TEST(CornerError, NeedsABoardThatShowsItsLens) {
  const Board small =
      make_board(Checkerboard{.columns = 4, .rows = 5, .column_spacing = .1, .row_spacing = .1});
  std::vector<View> seen = views(small, .1, 0);
  EXPECT_EQ(error_of(seen, small), 0);
}

}  // namespace
}  // namespace tagcal::internal
