#include "tagcal/reproject/maps.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "poses.hpp"
#include "tagcal/error.hpp"
#include "tagcal/geometry/transform.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr ImageSize kMapSize = {1280, 800};
const Perspective kBrown({900, 910, 651, 388, -0.25, 0.08, 1e-3, -1e-3, 0.01, 0, 0, 0});
const Perspective kRationalLens({900, 910, 651, 388, 0.1, 0.05, 1e-3, -1e-3, 0.01, 0.3, 0.02,
                                 0.001});
const Fisheye kFisheyeLens({520, 522, 640, 400, 0.02, -0.01, 0.003, -0.0005});

cv::Matx33d matrix(const Lens& lens) {
  const auto p = parameters(lens);
  return {p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1};
}

std::vector<double> opencv_distortion(const Lens& lens) {
  const auto p = parameters(lens);
  if (std::holds_alternative<Fisheye>(lens)) return {p.begin() + 4, p.end()};
  return {p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11]};
}

// The largest difference of two maps where the pixel is in front of the camera and near the
// picture, in units of the last place of the float32 of OpenCV.
double units_in_last_place(const ImageF& ours, const cv::Mat& theirs) {
  double most = 0;
  for (int y = 0; y < ours.height(); ++y) {
    for (int x = 0; x < ours.width(); ++x) {
      const float a = ours(x, y), b = theirs.at<float>(y, x);
      if (a == kNoSource) continue;
      const float unit = std::nextafter(std::abs(b), 1e30F) - std::abs(b);
      // Near zero a float32 resolves less than the 1e-9 px that is asked for before rounding.
      most = std::max(most, std::abs(static_cast<double>(a) - b) / std::max(unit, 1e-9F));
    }
  }
  return most;
}

struct OpenCvMap {
  cv::Mat x, y;
};

OpenCvMap opencv_map(const Reprojection& r) {
  const Camera& target = std::get<Camera>(r.target);
  const Eigen::Matrix3d turn = r.camera_from_target.rotation_matrix().transpose();
  cv::Matx33d rotation;
  for (int i = 0; i < 9; ++i) rotation(i / 3, i % 3) = turn(i / 3, i % 3);
  const cv::Size size(target.image_size.width, target.image_size.height);
  OpenCvMap map;
  if (std::holds_alternative<Fisheye>(r.camera.lens))
    cv::fisheye::initUndistortRectifyMap(matrix(r.camera.lens), opencv_distortion(r.camera.lens),
                                         rotation, matrix(target.lens), size, CV_32FC1, map.x,
                                         map.y);
  else
    cv::initUndistortRectifyMap(matrix(r.camera.lens), opencv_distortion(r.camera.lens), rotation,
                                matrix(target.lens), size, CV_32FC1, map.x, map.y);
  return map;
}

class Maps : public testing::TestWithParam<int> {
 protected:
  Lens lens() const {
    if (GetParam() == 0) return kBrown;
    if (GetParam() == 1) return kRationalLens;
    return kFisheyeLens;
  }
};

TEST_P(Maps, EqualThoseOfOpenCvToOneUnitInTheLastPlace) {
  for (const Pose& turn :
       {Pose(), rotation_about_y(0.2) * rotation_about_x(-0.1) * rotation_about_z(0.4)}) {
    const Reprojection r{
        {lens(), kMapSize}, Camera{pinhole(700, 710, 600, 410), {1203, 811}}, turn};
    const PixelMap map = pixel_map(r);
    const OpenCvMap theirs = opencv_map(r);
    EXPECT_LE(units_in_last_place(map.x, theirs.x), 1);
    EXPECT_LE(units_in_last_place(map.y, theirs.y), 1);
  }
}

// Before rounding: the double precision of the chain beside OpenCV's projection of points.
TEST_P(Maps, BeforeRoundingTheyEqualProjectPointsTo1e9) {
  const Reprojection r{
      {lens(), kMapSize}, Camera{pinhole(700, 710, 600, 410), {1200, 800}}, rotation_about_y(0.2)};
  std::vector<Vector2d> ours;
  std::vector<cv::Point3d> points;
  for (int v = 0; v < 800; v += 37) {
    for (int u = 0; u < 1200; u += 41) {
      const Vector3d x = r.camera_from_target * Vector3d((u - 600) / 700.0, (v - 410) / 710.0, 1);
      if (const auto pixel = source_pixel(r, {u, v})) {
        ours.push_back(*pixel);
        points.emplace_back(x.x() / x.z(), x.y() / x.z(), 1);
      }
    }
  }
  std::vector<cv::Point2d> theirs;
  const cv::Vec3d zero(0, 0, 0);
  if (std::holds_alternative<Fisheye>(r.camera.lens))
    cv::fisheye::projectPoints(points, theirs, zero, zero, matrix(r.camera.lens),
                               opencv_distortion(r.camera.lens));
  else
    cv::projectPoints(points, zero, zero, matrix(r.camera.lens), opencv_distortion(r.camera.lens),
                      theirs);
  ASSERT_GT(ours.size(), 500U);
  for (std::size_t i = 0; i < ours.size(); ++i)
    EXPECT_LT(std::hypot(ours[i].x() - theirs[i].x, ours[i].y() - theirs[i].y), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Lenses, Maps, testing::Range(0, 3));

TEST(PixelMaps, OfACameraIntoItselfAreTheIdentity) {
  for (const Lens& lens : {Lens(kBrown), Lens(kFisheyeLens), Lens(pinhole(500, 500, 320, 240))}) {
    const Camera camera{lens, {640, 400}};
    const PixelMap map = pixel_map({camera, camera, {}});
    for (int v = 0; v < 400; ++v) {
      for (int u = 0; u < 640; ++u) {
        ASSERT_NEAR(map.x(u, v), u, 1e-9);
        ASSERT_NEAR(map.y(u, v), v, 1e-9);
      }
    }
  }
}

// The rows of the kernels, the rays one by one, and any number of threads give the same.
TEST(PixelMaps, DoNotDependOnThreadsAndAgreeWithSourcePixel) {
  const Camera camera{kFisheyeLens, kMapSize};
  const Pose turn = rotation_about_y(1.2);
  const std::vector<Target> targets = {
      Camera{pinhole(300, 300, 200, 150), {401, 301}}, Camera{kBrown, {401, 301}},
      Panorama{PanoramaKind::equirectangular, 80, {200, 150}, {401, 301}},
      Panorama{PanoramaKind::cylindrical, 80, {200, 150}, {401, 301}}};
  for (const Target& target : targets) {
    const Reprojection r{camera, target, turn};
    const PixelMap map = pixel_map(r), again = pixel_map(r, 3);
    EXPECT_EQ(map.x.pixels(), again.x.pixels());
    EXPECT_EQ(map.y.pixels(), again.y.pixels());
    int seen = 0;
    for (int v = 0; v < 301; v += 7) {
      for (int u = 0; u < 401; u += 7) {
        const auto pixel = source_pixel(r, {u, v});
        ASSERT_EQ(pixel.has_value(), map.x(u, v) != kNoSource);
        if (!pixel) continue;
        ++seen;
        EXPECT_LE(std::abs(pixel->x() - map.x(u, v)), 1e-7 * (1 + std::abs(pixel->x())));
        EXPECT_LE(std::abs(pixel->y() - map.y(u, v)), 1e-7 * (1 + std::abs(pixel->y())));
      }
    }
    EXPECT_GT(seen, 500);
  }
}

// Rays beside and behind the axis of a fisheye are in its panorama, not in a pinhole.
TEST(PixelMaps, PanoramasShowLongitudesAndLatitudes) {
  const Camera camera{Fisheye({300, 300, 639.5, 399.5, 0, 0, 0, 0}), kMapSize};
  const Panorama sphere{PanoramaKind::equirectangular, 100, {400, 200}, {801, 401}};
  const auto at = [&](double longitude, double latitude) {
    return source_pixel({camera, sphere, {}}, {400 + 100 * longitude, 200 + 100 * latitude});
  };
  EXPECT_LT((*at(0, 0) - Vector2d(639.5, 399.5)).norm(), 1e-9);
  EXPECT_LT((*at(2, 0) - Vector2d(639.5 + 600, 399.5)).norm(), 1e-9);  // behind the camera
  EXPECT_LT((*at(0, 1) - Vector2d(639.5, 399.5 + 300)).norm(), 1e-9);
  EXPECT_FALSE(at(3.2, 0));
  EXPECT_FALSE(at(0, 1.6));
  const Panorama drum{PanoramaKind::cylindrical, 100, {400, 200}, {801, 401}};
  const auto pixel = source_pixel({camera, drum, {}}, {400, 200 + 100 * std::tan(1.0)});
  EXPECT_LT((*pixel - Vector2d(639.5, 399.5 + 300)).norm(), 1e-9);
}

TEST(PixelMaps, APlaneIsSeenFromItsFrontOnly) {
  const Camera camera{kBrown, kMapSize};
  // 2 m ahead, facing the camera: x right, y up, z towards it.
  const Pose front = translation({0.1, 0.2, 2}) * rotation_about_x(kPi);
  const PlaneRaster plane{{-0.3, 0.2}, 0.001, {600, 400}};
  const auto pixel = source_pixel({camera, plane, front}, {100, 150});
  const Vector3d x = front * Vector3d(-0.3 + 0.1, 0.2 - 0.15, 0);
  ASSERT_TRUE(pixel);
  EXPECT_LT((*pixel - *project(camera.lens, x)).norm(), 1e-10);
  const Pose back = translation({0.1, 0.2, 2});
  EXPECT_FALSE(source_pixel({camera, plane, back}, {100, 150}));
  EXPECT_EQ(pixel_map({camera, plane, back}).x(100, 150), kNoSource);
}

TEST(PixelMaps, OfAPartEqualThePart) {
  const Camera camera{kBrown, kMapSize};
  const std::vector<Target> targets = {
      Camera{pinhole(700, 710, 600, 410), {700, 500}}, Camera{kFisheyeLens, {700, 500}},
      Panorama{PanoramaKind::cylindrical, 800, {350, 250}, {700, 500}},
      PlaneRaster{{-0.3, 0.2}, 0.001, {700, 500}}};
  const Pose pose = translation({0.1, 0.2, 2}) * rotation_about_x(kPi);
  for (const Target& target : targets) {
    const Pose camera_from_target = std::holds_alternative<PlaneRaster>(target) ? pose : Pose();
    const PixelMap whole = pixel_map({camera, target, camera_from_target});
    const PixelMap part =
        pixel_map({camera, cropped(target, 200, 100, {64, 48}), camera_from_target});
    for (int v = 0; v < 48; ++v)
      for (int u = 0; u < 64; ++u) ASSERT_NEAR(part.x(u, v), whole.x(200 + u, 100 + v), 1e-3);
  }
}

TEST(PixelMaps, RefuseWhatHasNoRays) {
  const Camera parallel{Parallel({100, 100, 320, 240, 0, 0}), {640, 480}};
  const Camera camera{kBrown, kMapSize};
  EXPECT_THROW(pixel_map({parallel, camera, {}}), Error);
  EXPECT_THROW(pixel_map({camera, parallel, {}}), Error);
  EXPECT_THROW(pixel_map({camera, Camera{kBrown, {0, 10}}, {}}), Error);
  const PlaneRaster plane{{-0.3, 0.2}, 0.001, {60, 40}};
  EXPECT_NE(pixel_map({parallel, plane, rotation_about_x(kPi)}).x(10, 10), kNoSource);
}

}  // namespace
}  // namespace tagcal
