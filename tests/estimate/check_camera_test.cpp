// Is a calibration still valid: false alarms, what changed, and what cannot be told.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "finding_cases.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/check_camera.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

const Model& kModel = Model::named("opencv5");

// What a calibration of the usual camera knows of it.
const MatrixX& usual_covariance() {
  static const MatrixX covariance = [] {
    CalibrateOptions options;
    options.model = "opencv5";
    return calibrate(make_world(opencv5_lens(), 1), options).claim->covariance;
  }();
  return covariance;
}

// A calibration of a true camera, with errors as its covariance says.
UncertainCamera calibrated(const Lens& truth, Random& random) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{Eigen::MatrixXd(usual_covariance())};
  Eigen::VectorXd error(kModel.num_free());
  for (Eigen::Index i = 0; i < error.size(); ++i)
    error[i] = std::sqrt(std::max(0.0, eigen.eigenvalues()[i])) * random.normal();
  error = eigen.eigenvectors() * error;
  std::vector<double> values = kModel.free_values(truth);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] += error[static_cast<Eigen::Index>(i)];
  return {&kModel, {*kModel.lens(values, {1280, 800}), {1280, 800}}, usual_covariance()};
}

WorldOptions pictures(int count) {
  WorldOptions options;
  options.num_views = count;
  return options;
}

Lens with(double focal_share, double centre_px, double k1 = 0) {
  auto p = std::get<Perspective>(opencv5_lens()).parameters();
  p[0] *= 1 + focal_share;
  p[1] *= 1 + focal_share;
  p[2] += centre_px;
  p[4] += k1;
  return Perspective(p);
}

TEST(CheckCamera, RaisesNoMoreFalseAlarmsThanItStates) {
  const int num_worlds = 2000;
  for (const int num_views : {2, 5}) {
    int alarms = 0, valid = 0;
    double sum = 0, squares = 0;
    for (int i = 0; i < num_worlds; ++i) {
      const auto seed = static_cast<std::uint64_t>(1000 + i);
      Random random(seed);
      const UncertainCamera known = calibrated(opencv5_lens(), random);
      const CameraCheck check =
          check_camera(make_world(opencv5_lens(), seed, pictures(num_views)), known);
      alarms += check.verdict == CheckVerdict::changed;
      valid += check.verdict == CheckVerdict::valid;
      sum += check.in_sigmas;
      squares += check.in_sigmas * check.in_sigmas;
    }
    std::printf("%d views: %d false alarms, %d valid of %d, score %.2f +- %.2f\n", num_views,
                alarms, valid, num_worlds, sum / num_worlds,
                std::sqrt(squares / num_worlds - sum * sum / num_worlds / num_worlds));
    EXPECT_LE(alarms, 0.012 * num_worlds) << num_views;
  }
}

TEST(CheckCamera, SaysHowMuchChanged) {
  Random random(3);
  const UncertainCamera known = calibrated(opencv5_lens(), random);
  const CameraCheck check = check_camera(make_world(with(0.02, 0), 5, pictures(6)), known);
  ASSERT_EQ(check.verdict, CheckVerdict::changed);
  ASSERT_TRUE(check.change);
  EXPECT_EQ(check.change->kind, ChangeKind::focal_length);
  ASSERT_EQ(check.change->parameters.size(), 2u);
  for (const ParameterChange& p : check.change->parameters) {
    EXPECT_NEAR(p.change, 18, 5 * p.sigma) << p.name;
    EXPECT_LT(p.sigma, 2);
  }
  EXPECT_GT(check.change->max_px, 5);
  const CameraCheck lens = check_camera(make_world(with(0, 0, 0.03), 5, pictures(6)), known);
  ASSERT_TRUE(lens.change);
  EXPECT_EQ(lens.change->kind, ChangeKind::lens);
}

// Larger noise than any file says is no change, and neither is a part of wrong corners; a lens
// that changed by much does not make its own corners outliers.
TEST(CheckCamera, TakesTheNoiseFromThePictures) {
  Random random(4);
  const UncertainCamera known = calibrated(opencv5_lens(), random);
  WorldOptions noisy = pictures(10);
  noisy.sigma_px = 1;
  noisy.outlier_share = 0.03;
  const CameraCheck still = check_camera(make_world(opencv5_lens(), 11, noisy), known);
  EXPECT_NE(still.verdict, CheckVerdict::changed) << still.in_sigmas;
  EXPECT_NEAR(still.cameras[0].sigma_px, 1, 0.05);
  const CameraCheck changed = check_camera(make_world(with(0.2, 60, 0.1), 11, noisy), known);
  EXPECT_EQ(changed.verdict, CheckVerdict::changed);
  EXPECT_NEAR(changed.cameras[0].sigma_px, 1, 0.05);
}

TEST(CheckCamera, CannotTellFromPicturesThatShowLittle) {
  Random random(5);
  const UncertainCamera known = calibrated(opencv5_lens(), random);
  WorldOptions frontal = pictures(3);
  frontal.max_tilt_deg = 0.5;
  const CameraCheck flat = check_camera(make_world(opencv5_lens(), 12, frontal), known);
  EXPECT_EQ(flat.verdict, CheckVerdict::cannot_tell) << flat.smallest_px;
  const CameraCheck one = check_camera(make_world(with(0.1, 0), 12, pictures(1)), known);
  EXPECT_EQ(one.verdict, CheckVerdict::cannot_tell);
  EXPECT_TRUE(codes_of(one.findings).contains("few_views"));
  Dataset repeated = make_world(with(0.1, 0), 12, pictures(1));
  repeated.views.push_back(repeated.views.front());
  const CameraCheck twice = check_camera(repeated, known);
  EXPECT_EQ(twice.verdict, CheckVerdict::cannot_tell);
  EXPECT_TRUE(codes_of(twice.findings).contains("view_repeated"));
  const CameraCheck none = check_camera(make_world(opencv5_lens(), 12, pictures(0)), known);
  EXPECT_EQ(none.verdict, CheckVerdict::cannot_tell);
  EXPECT_TRUE(codes_of(none.findings).contains("target_unseen"));
}

TEST(CheckCamera, TakesACameraWithoutCovarianceAsExact) {
  const UncertainCamera known{nullptr, {opencv5_lens(), {1280, 800}}, {}};
  CheckOptions options;
  options.limit_px = 2;
  const CameraCheck check =
      check_camera(make_world(opencv5_lens(), 13, pictures(8)), known, options);
  EXPECT_EQ(check.verdict, CheckVerdict::valid) << check.in_sigmas << " " << check.smallest_px;
  EXPECT_TRUE(codes_of(check.findings).contains("camera_exact"));
}

TEST(CheckCamera, RefusesWhatDoesNotFit) {
  const UncertainCamera known{nullptr, {opencv5_lens(), {1280, 720}}, {}};
  EXPECT_THROW(check_camera(make_world(opencv5_lens(), 13, pictures(2)), known), Error);
  const UncertainCamera right{nullptr, {opencv5_lens(), {1280, 800}}, {}};
  for (const double limit : {0.0, -1.0, std::nan("")}) {
    CheckOptions options;
    options.limit_px = limit;
    EXPECT_THROW(check_camera(make_world(opencv5_lens(), 13, pictures(2)), right, options), Error);
  }
}

TEST(CheckCamera, OnePictureBesideItsPose) {
  Random random(6);
  const UncertainCamera known = calibrated(opencv5_lens(), random);
  const Dataset still = make_world(opencv5_lens(), 14, pictures(20));
  for (const View& view : still.views)
    EXPECT_FALSE(contradiction_of_camera(view, still.boards, known)) << view.image;
  const Dataset changed = make_world(with(0, 0, 0.1), 14, pictures(20));
  int found = 0;
  for (const View& view : changed.views) {
    const auto finding = contradiction_of_camera(view, changed.boards, known);
    found += finding && finding->code == "camera_changed";
  }
  EXPECT_GE(found, 18);
}

}  // namespace
}  // namespace tagcal
