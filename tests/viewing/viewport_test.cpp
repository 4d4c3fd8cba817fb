#include "tagcal/viewing/viewport.hpp"

#include <gtest/gtest.h>

#include "poses.hpp"
#include "tagcal/error.hpp"
#include "tagcal/viewing/projection.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const Camera kCamera{Perspective({900, 910, 651, 388, -0.2, 0.05, 1e-3, -1e-3, 0.01, 0, 0, 0}),
                     {1280, 800}};

TEST(Viewport, TakesAWindowToIt) {
  const Eigen::Matrix3d m = viewport_from_window({0, 0.5, 10, 30}, {-2, 2, -1, 1});
  EXPECT_TRUE((m * Vector3d(-2, -1, 1)).isApprox(Vector3d(0, 10, 1), 1e-15));
  EXPECT_TRUE((m * Vector3d(2, 1, 1)).isApprox(Vector3d(0.5, 30, 1), 1e-15));
  EXPECT_TRUE((m * Vector3d(0, 0, 1)).isApprox(Vector3d(0.25, 20, 1), 1e-15));
  EXPECT_THROW(viewport_from_window({0, 1, 0, 1}, {1, 1, 0, 1}), Error);
}

TEST(Viewport, OfTheUnitSquareScalesByHalfTheSize) {
  const Eigen::Matrix3d m = viewport_from_window({0, 1200, 0, 800}, {-1, 1, -1, 1});
  Eigen::Matrix3d expected;
  expected << 600, 0, 600, 0, 400, 400, 0, 0, 1;
  EXPECT_TRUE(m.isApprox(expected, 1e-15)) << m;
}

// A film at any distance shows the same picture: the viewport scales its window.
TEST(Viewport, ItDoesNotMatterWhereTheFilmIs) {
  const Camera camera{pinhole(480, 480, 319.5, 239.5), {640, 480}};
  const Vector3d x(0.25, -0.15, 1.2);
  for (const double d : {0.1, 1.0, 7.0}) {
    const Window film{-320 * d / 480, 320 * d / 480, -240 * d / 480, 240 * d / 480};
    const Eigen::Vector3d on_film = *divided(perspective_from_origin(d) * x.homogeneous());
    const Eigen::Vector3d pixel = viewport_from_window({-0.5, 639.5, -0.5, 479.5}, film) *
                                  Vector3d(on_film.x(), on_film.y(), 1);
    EXPECT_LT((pixel.head<2>() - *project(camera.lens, x)).norm(), 1e-12);
  }
}

TEST(Raster, IsHalfTheSizeTimesNdcAndItsCentre) {
  const Matrix4d m = raster_from_ndc({{640, 480}, {0, 0}, false});
  Matrix4d expected = Matrix4d::Identity();
  expected(0, 0) = 640 / 2.0;
  expected(0, 3) = (640 - 1) / 2.0;
  expected(1, 1) = 480 / 2.0;
  expected(1, 3) = (480 - 1) / 2.0;
  EXPECT_EQ(m, expected);
}

TEST(Raster, HasPixelCentresAtWholeNumbers) {
  const Matrix4d down = raster_from_ndc({{640, 480}});
  const auto at = [](const Matrix4d& m, double x, double y) {
    return Vector2d((m * Eigen::Vector4d(x, y, 0, 1)).head<2>());
  };
  EXPECT_EQ(at(down, -1, 1), Vector2d(-0.5, -0.5));  // the upper left corner of the image
  EXPECT_EQ(at(down, 1, -1), Vector2d(639.5, 479.5));
  const Matrix4d up = raster_from_ndc({{640, 480}, {0, 0}, false});
  EXPECT_EQ(at(up, -1, -1), Vector2d(-0.5, -0.5));
  const Matrix4d moved = raster_from_ndc({{640, 480}, {100, 50}});
  EXPECT_EQ(at(moved, -1, 1), Vector2d(99.5, 49.5));
}

TEST(Sectors, CoverTheImageOnce) {
  for (const auto& [columns, rows] : {std::pair(1, 1), std::pair(3, 2), std::pair(7, 11)}) {
    const ImageSize size{101, 53};
    std::vector<int> seen(101 * 53, 0);
    for (const PixelRectangle& part : sectors(size, columns, rows)) {
      EXPECT_NEAR(part.size.width, 101.0 / columns, 1);
      EXPECT_NEAR(part.size.height, 53.0 / rows, 1);
      for (int y = part.y; y < part.y + part.size.height; ++y)
        for (int x = part.x; x < part.x + part.size.width; ++x) ++seen[y * 101 + x];
    }
    EXPECT_TRUE(std::ranges::all_of(seen, [](int times) { return times == 1; }));
  }
  EXPECT_THROW(sectors({10, 10}, 11, 1), Error);
  EXPECT_THROW(sectors({10, 10}, 0, 1), Error);
}

TEST(Sectors, AreOffCentreFrustaThatMeet) {
  const Camera camera = undistorted(kCamera);
  const Window whole = view_volume(camera, 1, 10).window;
  const auto parts = sectors(camera.image_size, 2, 2);
  std::vector<Window> windows;
  for (const PixelRectangle& part : parts)
    windows.push_back(view_volume(cropped(camera, part), 1, 10).window);
  EXPECT_NEAR(windows[0].left, whole.left, 1e-15);
  EXPECT_NEAR(windows[0].right, windows[1].left, 1e-15);
  EXPECT_NEAR(windows[1].right, whole.right, 1e-15);
  EXPECT_NEAR(windows[0].bottom, windows[2].top, 1e-15);
  EXPECT_NEAR(windows[2].bottom, whole.bottom, 1e-15);
}

// Where a point of the scene lands on the new pixels, from where it lands on the old ones.
void expect_pixels(const Camera& changed, const std::function<Vector2d(const Vector2d&)>& moved) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Vector3d x(random.uniform(-0.7, 0.7), random.uniform(-0.4, 0.4), 1);
    const Vector2d before = project(kCamera.lens, x).value();
    EXPECT_LT((project(changed.lens, x).value() - moved(before)).norm(), 1e-9);
  }
}

TEST(Crop, MovesThePrincipalPoint) {
  const Camera crop = cropped(kCamera, {100, 50, {320, 240}});
  EXPECT_EQ(crop.image_size, (ImageSize{320, 240}));
  EXPECT_EQ(parameters(crop.lens)[2], 551);
  expect_pixels(crop, [](const Vector2d& p) { return Vector2d(p - Vector2d(100, 50)); });
  EXPECT_THROW(cropped(kCamera, {0, 0, {0, 10}}), Error);
}

TEST(Bin, PutsTheCentreOfABinAtAWholeNumber) {
  const Camera bin = binned(kCamera, 2, 4);
  EXPECT_EQ(bin.image_size, (ImageSize{640, 200}));
  EXPECT_EQ(parameters(bin.lens)[2], (651 + 0.5) / 2 - 0.5);
  // Pixels 0 and 1 make bin 0, whose centre was at 0.5.
  expect_pixels(bin,
                [](const Vector2d& p) { return Vector2d((p.x() - 0.5) / 2, (p.y() - 1.5) / 4); });
  EXPECT_THROW(binned(kCamera, 0, 1), Error);
  EXPECT_THROW(binned(kCamera, 2000, 1), Error);
}

TEST(Resize, KeepsTheBorderOfTheImage) {
  const Camera small = resized(kCamera, {640, 200});
  EXPECT_EQ(parameters(small.lens)[0], 450);
  expect_pixels(small, [](const Vector2d& p) {
    return Vector2d((p.x() + 0.5) / 2 - 0.5, (p.y() + 0.5) / 4 - 0.5);
  });
  EXPECT_THROW(resized(kCamera, {-1, 4}), Error);
}

TEST(FieldOfView, OfACentredPinhole) {
  const Camera camera{pinhole(900, 900, 639.5, 399.5), {1280, 800}};
  const FieldOfView fov = field_of_view(camera).value();
  EXPECT_NEAR(fov.horizontal_rad, field_of_view_rad(900, 1280), 1e-15);
  EXPECT_NEAR(fov.vertical_rad, field_of_view_rad(900, 800), 1e-15);
  EXPECT_NEAR(fov.diagonal_rad, field_of_view_rad(900, std::hypot(1280, 800)), 1e-15);
  EXPECT_NEAR(field_of_view_rad(fov.horizontal_rad, 1280, 800), fov.vertical_rad, 1e-15);
  EXPECT_NEAR(field_of_view_rad(fov.vertical_rad, 800, std::hypot(1280, 800)), fov.diagonal_rad,
              1e-15);
  EXPECT_NEAR(focal_from_field_of_view_px(fov.diagonal_rad, std::hypot(1280, 800)), 900, 1e-12);
}

TEST(FieldOfView, OfAnOffCentrePinholeIsTheSumOfItsSides) {
  const Camera camera{pinhole(100, 100, -0.5, 49.5), {100, 100}};
  EXPECT_NEAR(field_of_view(camera)->horizontal_rad, kPi / 4, 1e-15);
  EXPECT_NEAR(field_of_view(camera)->vertical_rad, 2 * std::atan(0.5), 1e-15);
}

TEST(FieldOfView, OfAFisheyeMayExceedAHalfTurn) {
  const Camera camera{Fisheye({300, 300, 639.5, 399.5, 0, 0, 0, 0}), {1280, 800}};
  const FieldOfView fov = field_of_view(camera).value();
  EXPECT_NEAR(fov.horizontal_rad, 1280.0 / 300, 1e-12);
  EXPECT_GT(fov.horizontal_rad, kPi);
  const Camera wide{Fisheye({100, 100, 639.5, 399.5, 0, 0, 0, 0}), {1280, 800}};
  EXPECT_FALSE(field_of_view(wide));  // the border is beyond the lens
  EXPECT_FALSE(field_of_view({Parallel({1, 1, 0, 0}), {10, 10}}));
}

// The three steps of the lecture: [-1, 1] to [-1/2, n_z - 1/2].
TEST(Viewport, DepthHasLevelsToo) {
  const Eigen::Matrix4d raster = raster_from_ndc({{640, 480}, {0, 0}, true, 256});
  EXPECT_EQ(raster.row(2), Eigen::RowVector4d(0, 0, 128, 127.5));
  EXPECT_EQ(raster_from_ndc({{640, 480}}).row(2), Eigen::RowVector4d(0, 0, 1, 0));
}

TEST(Viewport, TheCameraBehindAWindowLooksAlongItsNormal) {
  const WindowInWorld window{{-1, 2, 0}, {1, 2, 0}, {-1, 2, 1}};
  const CameraBehindWindow centred = camera_behind(window, {0, 0, 0.5}, {400, 200});
  const auto p = parameters(centred.camera.lens);
  EXPECT_NEAR(p[0], 400, 1e-12);  // 2 m before a window of 200 pixels a metre
  EXPECT_NEAR(p[1], 400, 1e-12);
  EXPECT_NEAR(p[2], 199.5, 1e-12);
  EXPECT_NEAR(p[3], 99.5, 1e-12);
  // Moving the eye sideways moves the principal point with it, and turns nothing.
  const CameraBehindWindow aside = camera_behind(window, {0.25, 0, 0.5}, {400, 200});
  EXPECT_NEAR(parameters(aside.camera.lens)[2], 249.5, 1e-12);
  EXPECT_EQ(angle_between_rad(aside.camera_from_world, centred.camera_from_world), 0);
  EXPECT_THROW(camera_behind(window, {0, 3, 0.5}, {400, 200}), Error);
  EXPECT_THROW(camera_behind({{-1, 2, 0}, {1, 2, 0}, {-0.9, 2, 1}}, {0, 0, 0}, {4, 4}), Error);
  EXPECT_THROW(camera_behind({{1, 2, 0}, {1, 2, 0}, {-1, 2, 1}}, {0, 0, 0}, {4, 4}), Error);
}

}  // namespace
}  // namespace tagcal
