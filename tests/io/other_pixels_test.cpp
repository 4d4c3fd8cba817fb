#include <gtest/gtest.h>

#include <Eigen/LU>

#include "file_fixture.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/viewing/viewport.hpp"

// What the file of a camera knows, of pictures that are a part of its own, or scaled.

namespace tagcal {
namespace {

using Eigen::Vector2d;

constexpr ImageSize kSize{640, 480};
constexpr PixelRectangle kPart{40, 60, {500, 400}};
const Vector2d kScale(0.5, 0.75);  // to 250 x 300

Vector2d moved(const Vector2d& pixel) {
  const Vector2d half(0.5, 0.5);
  return kScale.cwiseProduct(pixel - Vector2d(kPart.x, kPart.y) + half) - half;
}

// With correlations, and a distortion where the model has one.
CalibrationFile file_of(const std::string& name) {
  const Model& model = Model::named(name);
  const int n = model.num_free();
  std::vector<double> values;
  for (int i = 0; i < n; ++i) {
    const int lens_parameter = model.free()[static_cast<std::size_t>(i)].lens_parameters.front();
    values.push_back(lens_parameter < 2 ? 500 : lens_parameter < 4 ? 300 - 70 * i : 0.01);
  }
  CalibrationFile file;
  file.camera = {*model.lens(values, kSize), kSize};
  file.model = name;
  Eigen::MatrixXd root = 0.01 * Eigen::MatrixXd::Identity(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) root(i, j) = 1e-3 * (i + 2 * j + 1);
  file.covariance = root * root.transpose();
  file.sigmas = lens_sigmas({&model, file.camera, file.covariance});
  file.camera_error_px = 0.2;
  file.seen = SeenRegion(kSize, std::vector<Vector2d>{{0, 100}, {639, 100}, {639, 470}, {0, 470}});
  return file;
}

CameraFile moved_file(const CalibrationFile& known) {
  CameraFile file;
  file.format = "tagcal";
  file.cameras.push_back({"", known});
  const Camera camera = resized(cropped(known.camera, kPart), {250, 300});
  put_on_pixels(file, std::vector{camera});
  return file;
}

class OtherPixels : public FileTest {};

TEST_F(OtherPixels, ProjectionsHaveTheSameCovariances) {
  for (const char* const name :
       {"f", "f+c", "radial1", "opencv4", "opencv5", "opencv8", "fisheye4"}) {
    SCOPED_TRACE(name);
    const CalibrationFile before = file_of(name);
    const std::string written = (folder_ / "k.yaml").string();
    write_camera_file(written, moved_file(before), "tagcal");
    const CalibrationFile after = read_one_camera(written).cameras[0].calibration;
    for (const Eigen::Vector3d& x :
         {Eigen::Vector3d(0.1, 0.2, 1), Eigen::Vector3d(0.3, -0.4, 1.2)}) {
      const auto a = *project(uncertain_camera(before), UncertainPoint{x, {}});
      const auto b = *project(uncertain_camera(after), UncertainPoint{x, {}});
      const Matrix2 expected = kScale.asDiagonal() * a.covariance_px2 * kScale.asDiagonal();
      EXPECT_LT((b.pixel - moved(a.pixel)).norm(), 1e-9);
      EXPECT_LT((b.covariance_px2 - expected).norm(), 1e-6 * expected.norm());
    }
    EXPECT_DOUBLE_EQ(*after.camera_error_px, 0.2 * 0.75);
  }
}

TEST_F(OtherPixels, TheRegionIsCutToTheImage) {
  const SeenRegion seen = moved_file(file_of("opencv5")).cameras[0].calibration.seen;
  EXPECT_EQ(seen.size(), (ImageSize{250, 300}));
  EXPECT_TRUE(seen.contains(moved({200, 101})));
  EXPECT_FALSE(seen.contains(moved({200, 99})));
  EXPECT_LT(seen.share(), 1);
}

TEST_F(OtherPixels, HeldParametersStayHeld) {
  CalibrationFile file = file_of("opencv5");
  file.fixed = {{"f", 500}, {"k1", 0.01}};
  const HeldModels models(file.fixed, kind_of(file.camera.lens));
  file.covariance = covariance_by(models.named("opencv5"),
                                  {&Model::named("opencv5"), file.camera, file.covariance});
  const CalibrationFile after = moved_file(file).cameras[0].calibration;
  EXPECT_EQ(after.fixed, (std::map<std::string, double>{{"fx", 250}, {"fy", 375}, {"k1", 0.01}}));
  EXPECT_EQ(after.covariance.rows(), file.covariance.rows());
}

// The joint covariance of a rig, of places and lenses: its lens is a pinhole with one f.
TEST_F(OtherPixels, PlacesOfARigKeepTheirCorrelations) {
  CameraFile file;
  file.cameras = {{"a", file_of("f")}, {"b", file_of("opencv5")}};
  const Eigen::Index n = 12 + 1 + file.cameras[1].calibration.covariance.rows();
  Eigen::MatrixXd root = Eigen::MatrixXd::Identity(n, n);
  root.col(0).setOnes();
  file.rig_covariance = root * root.transpose();
  const auto camera = [&](std::size_t c) {
    return resized(cropped(file.cameras[c].calibration.camera, kPart), {250, 300});
  };
  put_on_pixels(file, std::vector{camera(0), camera(1)});
  const Eigen::Index first = 12, usual = Model::named("opencv5").num_free();
  ASSERT_EQ(file.rig_covariance.rows(), 12 + 2 * usual);
  EXPECT_EQ(file.rig_covariance(7, 3), 1);
  EXPECT_EQ(file.rig_covariance(7, first), kScale.x());      // fx of a
  EXPECT_EQ(file.rig_covariance(7, first + 1), kScale.y());  // fy of a
  EXPECT_EQ(file.rig_covariance(first, first + 1), 2 * kScale.x() * kScale.y());
  EXPECT_EQ(file.rig_covariance(first + 2, first + 2), 0);  // cx of a is held
  EXPECT_EQ(file.rig_covariance(first, first + usual), kScale.x() * kScale.x());
}

}  // namespace
}  // namespace tagcal
