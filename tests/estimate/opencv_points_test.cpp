// Point sets made by OpenCV: its projection, its rotations, the noise of the standard library.

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <random>

#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"

namespace tagcal {
namespace {

struct CvCamera {
  const char* model;
  std::vector<double> k;           // fx fy cx cy
  std::vector<double> distortion;  // in OpenCV's order
  double nearest_m, furthest_m;
};

bool is_fisheye(const CvCamera& camera) { return std::string(camera.model) == "fisheye4"; }

std::vector<cv::Point2d> project_by_opencv(const CvCamera& camera,
                                           const std::vector<cv::Point3d>& points,
                                           const cv::Vec3d& rotation, const cv::Vec3d& t) {
  const cv::Matx33d k(camera.k[0], 0, camera.k[2], 0, camera.k[1], camera.k[3], 0, 0, 1);
  std::vector<cv::Point2d> pixels;
  if (is_fisheye(camera))
    cv::fisheye::projectPoints(points, pixels, rotation, t, k, camera.distortion);
  else
    cv::projectPoints(points, rotation, t, k, camera.distortion, pixels);
  return pixels;
}

// A board of 6 x 6 tags before the camera, turned by up to 40 degrees about any axis.
Dataset made_by_opencv(const CvCamera& camera, unsigned seed, double sigma_px) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> noise(0, sigma_px);
  Dataset set;
  set.image_size = {1280, 800};
  set.boards = {{make_board(AprilGrid{6, 6, 0.088, 0.3, 0}), Pose()}};
  const auto target = target_points(set.boards[0].board);
  const cv::Matx33d facing(1, 0, 0, 0, -1, 0, 0, 0, -1);
  for (int v = 0; v < 12; ++v) {
    cv::Matx33d turn;
    cv::Rodrigues(cv::Vec3d(0.7 * unit(engine), 0.7 * unit(engine), 3.1 * unit(engine)), turn);
    cv::Vec3d rotation;
    cv::Rodrigues(turn * facing, rotation);
    const double z =
        camera.nearest_m + 0.5 * (unit(engine) + 1) * (camera.furthest_m - camera.nearest_m);
    const cv::Vec3d t(0.2 * z * unit(engine), 0.15 * z * unit(engine), z);
    std::vector<cv::Point3d> points;
    for (const TargetPoint& p : target)
      points.emplace_back(p.position.x() - 0.33, p.position.y() - 0.33, p.position.z());
    const auto pixels = project_by_opencv(camera, points, rotation, t);
    View view;
    view.image = std::to_string(v) + ".png";
    for (std::size_t i = 0; i < target.size(); ++i) {
      const Eigen::Vector2d pixel(pixels[i].x, pixels[i].y);
      if (contains(set.image_size, pixel))
        view.observations.push_back(
            {target[i].id, pixel + Eigen::Vector2d(noise(engine), noise(engine)), {}});
    }
    set.views.push_back(view);
  }
  return set;
}

Lens lens_of(const CvCamera& camera) {
  std::vector<double> values = camera.k;
  values.insert(values.end(), camera.distortion.begin(), camera.distortion.end());
  if (is_fisheye(camera)) {
    std::array<double, Fisheye::kNumParameters> p{};
    std::copy(values.begin(), values.end(), p.begin());
    return Fisheye(p);
  }
  std::array<double, Perspective::kNumParameters> p{};
  std::copy(values.begin(), values.end(), p.begin());
  return Perspective(p);
}

class OpenCvPoints : public testing::TestWithParam<CvCamera> {};

TEST_P(OpenCvPoints, TruthIsWithinThreeStandardDeviations) {
  const CvCamera& camera = GetParam();
  const bool rational = std::string(camera.model) == "opencv8";
  const Lens truth = lens_of(camera);
  int judged = 0, beyond = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Dataset set = made_by_opencv(camera, seed, 0.2);
    CalibrateOptions options;
    options.model = camera.model;
    const Calibration c = calibrate(set, options);
    ASSERT_EQ(c.status, Status::ok) << seed;
    EXPECT_NEAR(c.sigma_px, 0.2, 0.015);
    const auto found = parameters(c.camera->lens), wanted = parameters(truth);
    // The rational lens' coefficients trade with the focal lengths: what counts is what it
    // projects.
    for (std::size_t i = rational ? 2 : 0; i < (rational ? 4 : found.size()); ++i) {
      if (c.sigmas[i] == 0) continue;
      const double error = std::abs(found[i] - wanted[i]) / c.sigmas[i];
      EXPECT_LT(error, 4.5) << "parameter " << i << " seed " << seed;
      ++judged;
      beyond += error > 3;
    }
    const auto d = lens_difference({truth, set.image_size}, *c.camera, c.seen.samples(),
                                   c.projection.back().distance_m);
    ASSERT_TRUE(d.has_value());
    EXPECT_LT(d->rms_px, 3 * std::sqrt(2.0) * c.projection.back().region_px) << seed;
    EXPECT_LT(d->rms_px, 0.15) << seed;
  }
  // 0.27 % of normal deviates are beyond three.
  EXPECT_LE(beyond, 1 + judged / 100);
}

TEST_P(OpenCvPoints, ExactPointsGiveTheLens) {
  CalibrateOptions options;
  options.model = GetParam().model;
  const Dataset set = made_by_opencv(GetParam(), 3, 0);
  const Calibration c = calibrate(set, options);
  ASSERT_EQ(c.status, Status::ok);
  const auto d = lens_difference({lens_of(GetParam()), set.image_size}, *c.camera, c.seen.samples(),
                                 c.projection.back().distance_m);
  ASSERT_TRUE(d.has_value());
  EXPECT_LT(d->max_px, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(
    Cameras, OpenCvPoints,
    testing::Values(
        CvCamera{"pinhole", {900, 896, 651, 392}, {0, 0, 0, 0}, 0.7, 1.2},
        CvCamera{"opencv5", {910, 904, 630, 411}, {-0.21, 0.09, 7e-4, -5e-4, -0.02}, 0.7, 1.2},
        CvCamera{"opencv8",
                 {500, 501, 651, 392},
                 {0.5, 0.1, 5e-4, -3e-4, 0.01, 0.8, 0.15, 0.02},
                 0.4,
                 0.8},
        CvCamera{"fisheye4", {420, 419, 633, 405}, {0.02, -0.01, 0.003, -0.0005}, 0.4, 0.8}),
    [](const auto& camera) { return std::string(camera.param.model); });

}  // namespace
}  // namespace tagcal
