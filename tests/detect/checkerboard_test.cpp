#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "expect.hpp"
#include "markers_of_opencv.hpp"
#include "rendered_checkerboard.hpp"
#include "tagcal/detect/checker_search/checker_corners.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/explain.hpp"
#include "tagcal/detect/refine.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;

const ImageSize kSize{480, 360};

Camera camera(int i) {
  const Lens lenses[] = {pinhole(420, 420, 242, 178), Perspective({420, 420, 242, 178, -.3, .1}),
                         Fisheye({170, 170, 242, 178, -.02, .004, -.002, 0})};
  return {lenses[i % 3], kSize};
}

Board checkers(int columns, int rows, bool starts_black = true) {
  return make_board(Checkerboard{.columns = columns,
                                 .rows = rows,
                                 .column_spacing = .03,
                                 .row_spacing = .03,
                                 .starts_black = starts_black});
}

DetectedPicture found(const CheckerView& view) {
  return detect(view.image, {{view.board, Pose()}}, {}, "a.png");
}

// Mean square error in claimed variances.
double nees(const View& seen, const CheckerView& view) {
  double sum = 0;
  for (const Observation& one : seen.observations) {
    const Vector2d error = one.pixel - view.corners.at(one.id);
    EXPECT_LT(error.norm(), 0.3) << one.id.tag_id;
    sum += error.dot(one.covariance_px2->inverse() * error) / 2;
  }
  return sum / static_cast<double>(seen.observations.size());
}

TEST(Checkerboards, AreFoundWithTheirCovariances) {
  Random random(3);
  double sum = 0;
  for (int i = 0; i < 6; ++i) {
    const CheckerView view = checker_view(checkers(8, 5), camera(i),
                                          {random.uniform(13, 24), random.uniform(0, 50),
                                           random.uniform(.5, 1.4), 2, random.uniform(-1, 1)},
                                          random);
    ASSERT_TRUE(view.is_whole) << i;
    const View seen = found(view).view;
    ASSERT_EQ(seen.observations.size(), 40U) << i;
    sum += nees(seen, view) / 6;
  }
  EXPECT_GT(sum, 0.7);
  EXPECT_LT(sum, 1.4);
}

// What a camera's unsharp mask makes of a picture: borders of one pixel, with a dark and a bright
// line beside them.
Image8 sharpened(const ImageView8& image, double amount, double radius_px) {
  const cv::Mat given(image.height(), image.width(), CV_8U,
                      const_cast<std::uint8_t*>(image.row(0)));  // OpenCV takes no constant data
  cv::Mat levels, smooth, result;
  given.convertTo(levels, CV_32F);
  cv::GaussianBlur(levels, smooth, {}, radius_px);
  cv::addWeighted(levels, 1 + amount, smooth, -amount, 0, levels);
  levels.convertTo(result, CV_8U);
  Image8 sharp(image.size());
  for (int y = 0; y < image.height(); ++y) std::copy_n(result.ptr(y), image.width(), sharp.row(y));
  return sharp;
}

// Without damped steps one of these corners is lost, and one is 0.24 px off.
TEST(Checkerboards, OfSharpenedPicturesAreFoundWhole) {
  for (const std::uint64_t seed : {23U, 29U}) {
    Random random(seed);
    for (int i = 0; i < 3; ++i) {
      CheckerView view = checker_view(
          checkers(8, 5), camera(i),
          {random.uniform(28, 40), random.uniform(0, 30), .35, 1, random.uniform(-.3, .3)}, random);
      view.image = sharpened(view.image, 2, 2);
      const View seen = found(view).view;
      EXPECT_EQ(seen.observations.size(), 40U) << i;
      for (const Observation& one : seen.observations)
        EXPECT_LT((one.pixel - view.corners.at(one.id)).norm(), 0.1) << one.id.tag_id;
    }
  }
}

// Sharpening is found and undone: corners are as exact as without, and claim it. With overshoot
// that the fits do not know the sum is 0.08.
TEST(Checkerboards, ClaimsHoldInSharpenedPictures) {
  Random random(37);
  double sum = 0;
  for (int i = 0; i < 6; ++i) {
    CheckerView view = checker_view(
        checkers(8, 5), camera(i),
        {random.uniform(22, 30), random.uniform(0, 30), .8, 2, random.uniform(-.3, .3)}, random);
    view.image = sharpened(view.image, .8, 1.2);
    const View seen = found(view).view;
    ASSERT_EQ(seen.observations.size(), 40U) << i;
    sum += nees(seen, view) / 6;
  }
  EXPECT_GT(sum, 0.6);
  EXPECT_LT(sum, 1.5);
}

// A sensor's raw picture: red, green and blue filters before the pixels.
TEST(Checkerboards, OfRawMosaicsAreFoundAndNamed) {
  Random random(12);
  CheckerView view = checker_view(checkers(8, 5), camera(0), {22, 30, .8, 2, .3}, random);
  for (int y = 0; y < view.image.height(); ++y)
    for (int x = 0; x < view.image.width(); ++x)
      if (x % 2 == y % 2)
        view.image(x, y) = static_cast<std::uint8_t>((x % 2 == 0 ? .75 : .6) * view.image(x, y));
  const DetectedPicture picture = found(view);
  EXPECT_EQ(picture.view.observations.size(), 40U);
  EXPECT_LT(nees(picture.view, view), 3);
  ASSERT_EQ(picture.warnings.size(), 1U);
  EXPECT_EQ(picture.warnings[0],
            "a.png: is a raw mosaic (levels of even and odd pixels differ by a factor of 1.7): "
            "their levels were made equal");
}

// Steps of the grid shrink to a half from one square to the next, so that lines must be followed.
TEST(Checkerboards, OverHalfASphereAreFound) {
  Scene scene;
  scene.camera = {Fisheye({145, 145, 322, 238, .02, -.005, .001, 0}), {640, 480}};
  scene.boards = {{checkers(9, 6), Pose()}};
  scene.sensor.blur_px = .7;
  scene.sensor.noise_levels = 2;
  const std::vector<TargetPoint> points = target_points(scene.boards[0].board);
  int right = 0, found = 0;
  for (int i = 0; i < 3; ++i) {
    const Pose pose = camera_from_world_looking_at(Eigen::Vector3d(.12 + .01 * i, .075, .05),
                                                   Eigen::Vector3d(.14, .075 + .01 * i, 0),
                                                   Eigen::Vector3d(0, 1, 0));
    const Image8 image = expose(render_light(scene, {}, pose), scene.sensor, 1);
    for (const Observation& one : detect(image, scene.boards).view.observations) {
      const Eigen::Vector3d& point = points[static_cast<std::size_t>(one.id.tag_id)].position;
      const auto at = project(scene.camera.lens, pose * point);
      right += at && (one.pixel - *at).norm() < .3 ? 1 : 0;
      ++found;
    }
  }
  EXPECT_GE(right, 150);  // of 162
  // At the rim, where squares are 6 px wide, a corner may be taken for its neighbour.
  EXPECT_LE(found - right, 4);
}

// Colours tell which end is which if one number of squares is odd and the other even.
TEST(Checkerboards, HalfATurnIsResolvedByTheColours) {
  Random random(4);
  for (const bool starts_black : {false, true}) {
    for (const double roll : {0.0, std::numbers::pi}) {
      const CheckerView view =
          checker_view(checkers(8, 5, starts_black), camera(0), {20, 30, .8, 2, roll}, random);
      const DetectedPicture picture = found(view);
      ASSERT_EQ(picture.view.observations.size(), 40U);
      EXPECT_LT(nees(picture.view, view), 2);
      EXPECT_TRUE(picture.warnings.empty());
    }
  }
}

TEST(Checkerboards, BoardsThatLookTheSameAfterATurnAreSaidToBeAmbiguous) {
  Random random(5);
  for (const auto& [columns, rows, turn] :
       {std::tuple(7, 5, "half a turn"), {6, 6, "a quarter turn"}, {5, 5, "half a turn"}}) {
    const CheckerView upright =
        checker_view(checkers(columns, rows), camera(0), {20, 20, .8, 2, .3}, random);
    const CheckerView turned = checker_view(checkers(columns, rows), camera(0),
                                            {20, 20, .8, 2, std::numbers::pi + .3}, random);
    const std::vector<ImageSource> images = {{"a", [&] { return upright.image; }},
                                             {"b", [&] { return turned.image; }}};
    const std::vector<DetectedPicture> found = detect_all(images, {{upright.board, Pose()}});
    const auto warnings = board_warnings({{upright.board, Pose()}}, {});
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_HAS(warnings[0], turn);
    const auto last = static_cast<std::size_t>(columns * rows);
    ASSERT_EQ(found[0].view.observations.size(), last);
    EXPECT_LT(nees(found[0].view, upright), 2);
    ASSERT_EQ(found[1].view.observations.size(), last);
    // The board on its head is numbered from its other end.
    EXPECT_LT(
        (found[1].view.observations[0].pixel - turned.corners.at({static_cast<int>(last) - 1, 0}))
            .norm(),
        0.3);
  }
}

TEST(Checkerboards, PartsAndOtherBoardsAreNotReported) {
  Random random(6);
  CheckerView view = checker_view(checkers(8, 5), camera(0), {20, 10, .8, 2, .1}, random);
  view.board = checkers(9, 6);
  const DetectedPicture picture = found(view);
  EXPECT_TRUE(picture.view.observations.empty());
  ASSERT_EQ(picture.warnings.size(), 1U);
  EXPECT_HAS(picture.warnings[0], "is not seen whole: the largest grid has");
  const Explanation why = explain(view.image, {{view.board, Pose()}});
  ASSERT_EQ(why.checkerboards.size(), 1U);
  EXPECT_HAS(why.checkerboards[0], "not seen whole");
}

TEST(Checkerboards, AreNotFoundWhereThereIsNone) {
  Random random(8);
  Image8 noise(kSize);
  for (int y = 0; y < kSize.height; ++y)
    for (int x = 0; x < kSize.width; ++x)
      noise(x, y) = static_cast<std::uint8_t>(random.index(256));
  Scene scene;
  scene.camera = camera(0);
  scene.boards = {{make_board(AprilGrid{5, 4, .03, .3, 0}), Pose()}};
  const Pose pose(Eigen::Quaterniond(0, 1, 0, 0), {-.09, .07, .25});
  const Image8 tags =
      expose(render_light(scene, {{"tag36h11", tag_family("tag36h11", 2)}}, pose), scene.sensor, 1);
  for (const Image8* image : {static_cast<const Image8*>(&noise), &tags})
    for (const auto& [columns, rows] : {std::pair(2, 2), {3, 3}, {4, 3}, {8, 5}})
      EXPECT_TRUE(detect(*image, {{checkers(columns, rows), Pose()}}).view.observations.empty())
          << columns << " x " << rows;
}

// Junctions of noise, crossed waves, dots and printed lines stand in grids, too, but not between
// black and white squares.
TEST(Checkerboards, AreNotSeenInNoiseAndTextures) {
  constexpr int kKinds = 5;
  const PlacedBoard tags{make_board(AprilGrid{5, 4, .03, .3, 0}), Pose()};
  Random random(14);
  for (int i = 0; i < 3 * kKinds; ++i) {
    cv::Mat levels(240, 320, CV_32F, cv::Scalar(128)), shown;
    cv::RNG noise(random.next());
    if (i % kKinds == 0) noise.fill(levels, cv::RNG::UNIFORM, 0, 256);
    if (i % kKinds == 1) noise.fill(levels, cv::RNG::NORMAL, 128, 40);
    if (i % kKinds == 2) {
      noise.fill(levels, cv::RNG::NORMAL, 128, 300);
      cv::GaussianBlur(levels, levels, {}, 1.5 + i / kKinds);
    }
    const double period = random.uniform(9, 20);  // px
    for (int y = 0; y < levels.rows && i % kKinds == 3; ++y)
      for (int x = 0; x < levels.cols; ++x)
        levels.at<float>(y, x) +=
            static_cast<float>(60 * (std::sin(x / period * 2 * std::numbers::pi) +
                                     std::sin((y + .3 * x) / period * 2 * std::numbers::pi)));
    for (int k = 0; k < 400 && i % kKinds == 4; ++k)
      cv::circle(levels, {noise.uniform(0, 320), noise.uniform(0, 240)}, noise.uniform(2, 8),
                 cv::Scalar(noise.uniform(0, 256)), -1);
    levels.convertTo(shown, CV_8U);
    const ImageView8 image(shown.data, {shown.cols, shown.rows},
                           static_cast<std::ptrdiff_t>(shown.step));
    for (const std::string& mistake : explain(image, {tags}).mistakes)
      ADD_FAILURE() << i % kKinds << ": " << mistake;
    const DetectedPicture board = detect(image, {{checkers(8, 5), Pose()}});
    ASSERT_EQ(board.warnings.size(), 1U);
    EXPECT_EQ(board.warnings[0], "picture: no checkerboard found") << i % kKinds;
  }
}

// As if each corner went through the places of all.
TEST(Checkerboards, PlacesNearACornerAreThoseOfAllInTheirOrder) {
  Random random(12);
  internal::PlacesByCell places;
  std::vector<Vector2d> all;
  for (int i = 0; i < 400; ++i) {
    const bool is_corner = i % 2 == 0;
    const auto number = [&] { return is_corner ? i / 2 % 10 : random.uniform(-1, 11); };
    const Vector2d place(number(), is_corner ? i / 20 % 10 : number());
    places.put({place, Vector2d(i, 0)});
    std::erase(all, place);
    all.push_back(place);
  }
  for (const double reach : {1.5, 2.5})
    for (int column = 0; column < 10; ++column)
      for (int row = 0; row < 10; ++row) {
        std::vector<Vector2d> near, expected;
        for (const auto& one : places.near({column, row}, reach)) near.push_back(one.on_board);
        for (const Vector2d& place : all)
          if ((place - Vector2d(column, row)).cwiseAbs().maxCoeff() <= reach)
            expected.push_back(place);
        EXPECT_GT(expected.size(), 4U);
        EXPECT_EQ(near, expected);
      }
}

TEST(CharucoBoards, AreFoundInPart) {
  Random random(9);
  double sum = 0;
  int count = 0;
  for (const bool legacy : {false, true}) {
    for (int i = 0; i < 3; ++i) {
      const Board board = make_board(Charuco{8, 6, .03, .022, "DICT_5X5_100", legacy});
      const CheckerView view = checker_view(
          board, camera(i), {i == 1 ? 110.0 : 34.0, 30, .8, 2, random.uniform(-3, 3)}, random);
      const View seen = found(view).view;
      // Corners whose squares are cut by the picture's edge may be missing.
      EXPECT_GE(seen.observations.size() * 10, view.corners.size() * (i == 1 ? 8 : 10)) << i;
      EXPECT_EQ(view.corners.size() < 30, i == 1);
      sum += nees(seen, view);
      ++count;
    }
  }
  EXPECT_LT(sum / count, 1.5);
  EXPECT_GT(sum / count, 0.6);
}

// OpenCV's own drawing of its board is the witness for the places of the markers.
TEST(CharucoBoards, AreOpenCvs) {
  const cv::Mat drawing = charuco_of_opencv({6, 5, 1, 0.7F}, cv::aruco::DICT_4X4_50, 70).drawing;
  Image8 image({520, 450}, 255);
  for (int y = 0; y < 350; ++y)
    for (int x = 0; x < 420; ++x) image(50 + x, 50 + y) = drawing.at<unsigned char>(y, x);
  const Board board = make_board(Charuco{6, 5, 1, .7, "DICT_4X4_50"});
  const View seen = detect(image, {{board, Pose()}}).view;
  // A drawing without any blur is no picture of a camera: a corner of it may be refused.
  EXPECT_GE(seen.observations.size(), 18U);
  for (const Observation& one : seen.observations) {
    const int column = one.id.tag_id % 5, row = one.id.tag_id / 5;
    EXPECT_LT((one.pixel - Vector2d(119.5 + 70 * column, 119.5 + 70 * (3 - row))).norm(), 0.6);
  }
}

// All squares, however large.
TEST(CharucoBoards, LoseNoRowInClosePictures) {
  cv::Mat drawing = charuco_of_opencv({7, 5, 1, 0.75F}, cv::aruco::DICT_4X4_50, 96).drawing;
  cv::Mat smooth;
  cv::copyMakeBorder(drawing, drawing, 60, 60, 60, 60, cv::BORDER_CONSTANT, 255);
  cv::GaussianBlur(drawing, smooth, {}, 0.8);
  Image8 image({smooth.cols, smooth.rows});
  for (int y = 0; y < smooth.rows; ++y) std::copy_n(smooth.ptr(y), smooth.cols, image.row(y));
  const Board board = make_board(Charuco{7, 5, 1, .75, "DICT_4X4_50"});
  EXPECT_EQ(detect(image, {{board, Pose()}}).view.observations.size(), 24U);
}

// Noisy pictures of parts of a small board: in some of them markers are read, but every corner that
// was found at first is refused in the end.
TEST(CharucoBoards, WithoutCornersAreSaidNotToBeFound) {
  constexpr double kTurn = 2 * std::numbers::pi;
  Scene scene;
  scene.camera = {pinhole(200, 200, 99.5, 74.5), {200, 150}};
  scene.boards = {{make_board(Charuco{4, 3, .05, .037, "DICT_4X4_50", false}), Pose()}};
  scene.path = DomePath{{.1, .07, 0}, .2, .5, 0, kTurn, .26, kTurn / 4};
  scene.jitter = {0, .15, kTurn / 2};
  scene.sensor = {1, .6, 14};
  scene.num_views = 40;
  const TagFamilies families = tag_families(scene.boards);
  int num_refused = 0;
  for (const Pose& pose : camera_poses(scene, 0)) {
    const Image8 image = expose(render_light(scene, families, pose), scene.sensor, 3);
    const DetectedPicture seen = detect(image, scene.boards);
    if (!seen.view.observations.empty()) continue;
    ASSERT_EQ(seen.warnings.size(), 1U);
    num_refused += seen.warnings[0].find("do not look like its pattern") != std::string::npos;
  }
  EXPECT_GT(num_refused, 0);
}

TEST(RefineCorner, RefusesWhatIsNotThePattern) {
  Random random(10);
  const CheckerView view = checker_view(checkers(8, 5), camera(0), {20, 0, .8, 2, 0}, random);
  const Vector2d at = view.corners.at({11, 0}), right = view.corners.at({12, 0}),
                 up = view.corners.at({19, 0});
  CornerPattern pattern{{-1, 0, 1}, {-1, 0, 1}, {}};
  using enum TagPattern::Cell;
  Eigen::Matrix3d h = Eigen::Matrix3d::Identity();
  h.topLeftCorner<2, 1>() = right - at;
  h.block<2, 1>(0, 1) = up - at;
  h.topRightCorner<2, 1>() = at + Vector2d(.5, -.4);
  // Corner 11 is at column 3, row 1: its lower left square is black as that of the first corner.
  pattern.cells = {black, white, white, black};
  const CornerFit fit = refine_corner(view.image, pattern, h);
  ASSERT_EQ(fit.status, TagFitStatus::converged);
  EXPECT_LT((fit.corner - at).norm(), 0.05);
  pattern.cells = {white, black, black, white};
  EXPECT_NE(refine_corner(view.image, pattern, h).status, TagFitStatus::converged);
  pattern.cells = {black, white, white, black};
  h.topRightCorner<2, 1>() = (at + right) / 2;
  const CornerFit aside = refine_corner(view.image, pattern, h);
  EXPECT_TRUE(aside.status != TagFitStatus::converged || (aside.corner - at).norm() < .1 ||
              (aside.corner - right).norm() < .1);
}

}  // namespace
}  // namespace tagcal
