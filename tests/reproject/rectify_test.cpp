#include "tagcal/reproject/rectify.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>

#include "expect.hpp"
#include "tagcal/random.hpp"
#include "tagcal/reproject/maps.hpp"
#include "tagcal/reproject/resampling.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr ImageSize kRectifiedSize = {752, 480};

KnownRig::Member member(const Lens& lens, const Pose& camera_from_rig, const char* name = "a") {
  return {name, {nullptr, {lens, kRectifiedSize}, {}}, camera_from_rig, std::nullopt};
}

Lens perspective(double f, double cx, double cy, double scale) {
  return Perspective(
      {f, 1.003 * f, cx, cy, -0.28 * scale, 0.07 * scale, 2e-4 * scale, -3e-4 * scale, 0, 0, 0, 0});
}

// Cameras like those of EuRoC, with the second one right of the first one, or below it.
KnownRig pair_of(const Lens& a, const Lens& b, bool is_vertical = false) {
  const Pose place({1, 0, 0, 0}, {0.02, -0.01, 0.03});
  const Vector3d shift =
      is_vertical ? Vector3d(0.003, -0.12, 0.002) : Vector3d(-0.11, 0.004, -0.002);
  return {{member(a, place, "left"),
           member(b, Pose(exp_rotation({-0.014, 0.021, -0.009}), shift) * place, "right")},
          {}};
}

cv::Matx33d matrix_of(const Lens& lens) {
  const auto p = parameters(lens);
  return {p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1};
}

std::vector<double> distortion_of(const Lens& lens) {
  const auto p = parameters(lens);
  return {p.begin() + 4, p.begin() + 9};
}

struct OpenCv {
  cv::Matx33d r[2];
  cv::Matx34d p[2];
  cv::Matx44d q;
};

OpenCv rectified_by_opencv(const KnownRig& rig, double alpha, bool zero_disparity = true) {
  const Pose right_from_left =
      rig.cameras[1].camera_from_rig * rig.cameras[0].camera_from_rig.inverse();
  const Eigen::Matrix3d r = right_from_left.rotation_matrix();
  const Vector3d t = right_from_left.translation();
  const cv::Matx33d turn(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1),
                         r(2, 2));
  const Lens &a = rig.cameras[0].camera.camera.lens, &b = rig.cameras[1].camera.camera.lens;
  cv::Mat r1, r2, p1, p2, q;
  cv::stereoRectify(matrix_of(a), distortion_of(a), matrix_of(b), distortion_of(b),
                    {kRectifiedSize.width, kRectifiedSize.height}, turn,
                    cv::Vec3d(t.x(), t.y(), t.z()), r1, r2, p1, p2, q,
                    zero_disparity ? cv::CALIB_ZERO_DISPARITY : 0, alpha);
  return {{r1, r2}, {p1, p2}, q};
}

// The largest differences of rotations, and of P and Q.
struct Differences {
  double rotation = 0, matrices = 0;
};

template <typename Matrix, typename CvMatrix>
double difference_of(const Matrix& ours, const CvMatrix& theirs) {
  double most = 0;
  for (int i = 0; i < CvMatrix::rows; ++i)
    for (int j = 0; j < CvMatrix::cols; ++j)
      most = std::max(most, std::abs(ours(i, j) - theirs(i, j)));
  return most;
}

Differences differences(const KnownRig& rig, const RectifyOptions& options) {
  const RectifiedPair pair = rectify(rig, 0, 1, options);
  const OpenCv theirs =
      rectified_by_opencv(rig, options.alpha.value_or(-1), options.zero_disparity);
  Differences d;
  for (int k = 0; k < 2; ++k) {
    const Eigen::Matrix3d turn = pair.camera_from_rectified[k].rotation_matrix().transpose();
    d.rotation = std::max(d.rotation, difference_of(turn, theirs.r[k]));
    d.matrices = std::max(d.matrices, difference_of(projection_matrix(pair, k), theirs.p[k]));
  }
  d.matrices = std::max(d.matrices, difference_of(disparity_to_depth(pair), theirs.q));
  return d;
}

std::vector<RectifyOptions> all_options() {
  std::vector<RectifyOptions> all = {{{}, true, false}, {{}, false, false}};
  for (const double alpha : {0.0, 0.3, 1.0}) all.push_back({alpha, true, false});
  return all;
}

TEST(Rectify, IsThatOfOpenCv) {
  for (const bool is_vertical : {false, true})
    for (const RectifyOptions& options : all_options()) {
      SCOPED_TRACE(testing::Message() << is_vertical << " " << options.alpha.value_or(-1));
      // With alpha, OpenCV up to 4.6 takes its 9 x 9 points in single precision and up to the pixel
      // (width, height) beyond the last one; later versions up to the last one, as here.
      const double tolerance = options.alpha ? 0.3 : 1e-9;
      for (const double scale : {0.0, 0.02}) {
        const Differences d =
            differences(pair_of(perspective(458, 367.2, 248.4, scale),
                                perspective(457, 380.1, 255.2, scale), is_vertical),
                        options);
        EXPECT_LT(d.rotation, 1e-9) << scale;
        EXPECT_LT(d.matrices, tolerance) << scale;
      }
      // OpenCV stops its undistortion after five iterations, which leaves 0.05 px in the corners
      // of lenses like those of EuRoC.
      const Differences d = differences(pair_of(perspective(458, 367.2, 248.4, 1),
                                                perspective(457, 380.1, 255.2, 1), is_vertical),
                                        options);
      EXPECT_LT(d.rotation, 1e-9);
      EXPECT_LT(d.matrices, options.zero_disparity ? 0.5 : 2) << "px, and 1/m in Q";
    }
}

TEST(Rectify, MapsAreThoseOfOpenCv) {
  const KnownRig rig =
      pair_of(perspective(458, 367.2, 248.4, 1), perspective(457, 380.1, 255.2, 1));
  const RectifiedPair pair = rectify(rig, 0, 1, {0.0, true, false});
  for (std::size_t k = 0; k < 2; ++k) {
    const PixelMap map = pixel_map(rectification(rig, pair, k));
    const Lens& lens = rig.cameras[k].camera.camera.lens;
    const Eigen::Matrix3d r = pair.camera_from_rectified[k].rotation_matrix().transpose();
    const cv::Matx33d turn(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1),
                           r(2, 2));
    const ProjectionMatrix p = projection_matrix(pair, k);
    cv::Mat x, y;
    cv::initUndistortRectifyMap(matrix_of(lens), distortion_of(lens), turn,
                                cv::Matx33d(p(0, 0), 0, p(0, 2), 0, p(1, 1), p(1, 2), 0, 0, 1),
                                {kRectifiedSize.width, kRectifiedSize.height}, CV_32FC1, x, y);
    for (int v = 0; v < kRectifiedSize.height; ++v)
      for (int u = 0; u < kRectifiedSize.width; ++u) {
        ASSERT_LE(std::abs(map.x(u, v) - x.at<float>(v, u)), std::nextafter(752.F, 1e9F) - 752.F);
        ASSERT_LE(std::abs(map.y(u, v) - y.at<float>(v, u)), std::nextafter(752.F, 1e9F) - 752.F);
      }
  }
}

// Random points before both cameras have equal rows, and the disparity of their distance.
void expect_equal_rows(const KnownRig& rig, const RectifyOptions& options) {
  const RectifiedPair pair = rectify(rig, 0, 1, options);
  Random random(3, 0);
  int count = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vector3d x(random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(0.3, 4));
    std::array<UncertainPixel, 2> seen;
    std::array<Vector2d, 2> rectified;
    std::array<Vector3d, 2> at;
    bool is_seen = true;
    for (std::size_t k = 0; k < 2 && is_seen; ++k) {
      const KnownRig::Member& camera = rig.cameras[k];
      const Vector3d in_camera = camera.camera_from_rig * x;
      at[k] = pair.camera_from_rectified[k].inverse() * in_camera;
      const auto pixel = project(camera.camera.camera.lens, in_camera);
      is_seen = pixel && contains(kRectifiedSize, *pixel) && at[k].z() > 0.1;
      if (!is_seen) break;
      seen[k].pixel = *pixel;
      rectified[k] = rectified_pixel(rig, pair, k, *pixel).value();
      // The map takes the rectified pixel back.
      const auto back = source_pixel(rectification(rig, pair, k), rectified[k]);
      ASSERT_TRUE(back);
      ASSERT_LT((*back - *pixel).norm(), 1e-9);
    }
    if (!is_seen) continue;
    ++count;
    const int across = pair.is_vertical ? 0 : 1, along = 1 - across;
    ASSERT_NEAR(rectified[0][across], rectified[1][across], 1e-9);
    ASSERT_NEAR(vertical_disparity(rig, pair, seen)->difference_px, 0, 1e-9);
    if (options.longlat) {
      const auto s = std::get<Panorama>(pair.targets[0]).px_per_rad;
      const double centre = std::get<Panorama>(pair.targets[0]).centre[along];
      const double distance = std::hypot(at[0].z(), at[0][across]);
      EXPECT_NEAR(std::tan((rectified[0][along] - centre) / s) -
                      std::tan((rectified[1][along] - centre) / s),
                  -pair.translation_m / distance, 1e-9);
    } else {
      const Eigen::Vector4d point =
          disparity_to_depth(pair) * Eigen::Vector4d(rectified[0].x(), rectified[0].y(),
                                                     rectified[0][along] - rectified[1][along], 1);
      EXPECT_LT((point.hnormalized() - at[0]).norm(), 1e-7);
    }
  }
  EXPECT_GT(count, 100);
}

TEST(Rectify, CorrespondingPointsHaveEqualRows) {
  const Fisheye a({190, 190.5, 372, 241, 0.02, -0.01, 0.003, -0.0005});
  const Fisheye b({191, 191.5, 380, 245, 0.02, -0.01, 0.003, -0.0005});
  for (const bool is_vertical : {false, true})
    for (const bool longlat : {false, true}) {
      SCOPED_TRACE(testing::Message() << is_vertical << longlat);
      expect_equal_rows(pair_of(a, b, is_vertical), {{}, true, longlat});
      expect_equal_rows(pair_of(perspective(458, 367.2, 248.4, 1),
                                DoubleSphere({300, 300, 370, 240, -0.2, 0.59}), is_vertical),
                        {{}, true, longlat});
    }
  expect_equal_rows(pair_of(a, b), {1.0, true, false});
  expect_equal_rows(pair_of(a, b), {0.0, true, false});
}

TEST(Rectify, TheSecondCameraMayBeLeftOfTheFirst) {
  KnownRig rig = pair_of(perspective(458, 367.2, 248.4, 0), perspective(457, 380.1, 255.2, 0));
  const double translation = rectify(rig, 0, 1).translation_m;
  EXPECT_LT(translation, 0);
  EXPECT_NEAR(rectify(rig, 1, 0).translation_m, -translation, 1e-12);
  std::swap(rig.cameras[0], rig.cameras[1]);
  expect_equal_rows(rig, {});
}

std::string refusal_of(const KnownRig& rig, const RectifyOptions& options = {},
                       std::size_t second = 1) {
  return error_of([&] { rectify(rig, 0, second, options); });
}

KnownRig turned_pair(const Vector3d& turn, const Vector3d& translation) {
  const Lens lens = perspective(458, 375.5, 239.5, 0);
  return {
      {member(lens, Pose(), "left"), member(lens, Pose(exp_rotation(turn), translation), "right")},
      {}};
}

// Cameras whose axes diverge by an angle, symmetrically.
KnownRig toed_out(double angle_rad, double baseline_m) {
  return turned_pair({0, -angle_rad, 0},
                     exp_rotation({0, -angle_rad / 2, 0}) * Vector3d(-baseline_m, 0, 0));
}

TEST(Rectify, RefusesWhatHasNoRectifiedPicture) {
  const double pi = std::numbers::pi;
  const KnownRig rig = turned_pair({0, 0, 0}, {-0.1, 0, 0});
  EXPECT_EQ(refusal_of(rig), "no error");
  for (const double alpha : {-0.1, 1.1, std::nan("")})
    EXPECT_HAS(refusal_of(rig, {alpha, true, false}), "alpha must be from 0 to 1, got");
  EXPECT_HAS(refusal_of(rig, {0.5, true, true}), "alpha is of pinholes");
  EXPECT_HAS(refusal_of(rig, {}, 2), "the rig has 2 cameras, got the index 2");
  EXPECT_HAS(refusal_of(rig, {}, 0), "needs two cameras, got left twice");
  EXPECT_HAS(refusal_of(turned_pair({0, 0.1, 0}, {0, 0, 0})), "there is no baseline");
  // Face to face, back to back, one before the other.
  EXPECT_HAS(refusal_of(turned_pair({0, pi - 0.01, 0}, {0.001, 0, 1})), "look at each other");
  EXPECT_HAS(refusal_of(turned_pair({0, pi - 0.01, 0}, {0.001, 0, -1})), "look at each other");
  EXPECT_HAS(refusal_of(turned_pair({0, 0, 0}, {0.01, 0, 1})), "along their baseline");
  // 100 degrees apart, each 78 degrees wide, and their axes meet behind them.
  const KnownRig apart = toed_out(1.75, 0.1);
  EXPECT_HAS(refusal_of(apart), "no common field of view");
  EXPECT_HAS(refusal_of(apart, {{}, true, true}), "no common field of view");
  // Toed in by 126 degrees: OpenCV's focal length is negative.
  const KnownRig toed_in = toed_out(-2.2, 0.5);
  EXPECT_LT(rectified_by_opencv(toed_in, 0).p[0](0, 0), 0);
  EXPECT_HAS(refusal_of(toed_in, {0.0, true, false}), "left looks 63 degrees away from");
  const Lens parallel = Parallel({100, 100, 0, 0, 0, 0});
  EXPECT_HAS(refusal_of(pair_of(perspective(458, 367, 248, 0), parallel)), "parallel");
}

// Truths drawn from the joint covariance of places and lenses: the rows differ as the claim says.
TEST(Rectify, TheStandardDeviationOfVerticalDisparityHolds) {
  const Model& model = Model::named("opencv4");
  Random random(7, 0);
  const auto normal = [&] { return random.normal(); };
  for (const bool longlat : {false, true})
    for (const bool is_vertical : {false, true}) {
      KnownRig rig = pair_of(perspective(458, 367.2, 248.4, 1), perspective(457, 380.1, 255.2, 1),
                             is_vertical);
      for (auto& camera : rig.cameras) {
        camera.camera.model = &model;
        camera.camera.covariance = MatrixX::Zero(8, 8);
      }
      // Correlated, with places that are known to 0.3 mm and 0.4 mrad.
      Eigen::VectorXd scale(28);
      scale.head<12>() << 4e-4, 4e-4, 4e-4, 3e-4, 3e-4, 3e-4, 4e-4, 4e-4, 4e-4, 3e-4, 3e-4, 3e-4;
      for (int k = 0; k < 2; ++k)
        scale.segment<8>(12 + 8 * k) << 0.4, 0.4, 0.4, 0.4, 1e-3, 1e-3, 1e-4, 1e-4;
      Eigen::MatrixXd mix = Eigen::MatrixXd::NullaryExpr(28, 28, normal) / 10;
      mix += Eigen::MatrixXd::Identity(28, 28);
      const Eigen::MatrixXd root = scale.asDiagonal() * mix;
      rig.covariance = root * root.transpose();
      const RectifiedPair pair = rectify(rig, 0, 1, {{}, true, longlat});
      double nees = 0;
      int count = 0;
      while (count < 3000) {
        const Eigen::VectorXd error = root * Eigen::VectorXd::NullaryExpr(28, normal);
        const double z = std::exp(random.uniform(std::log(0.3), std::log(30)));
        const Vector3d x(z * random.uniform(-0.6, 0.6), z * random.uniform(-0.4, 0.4), z);
        std::array<UncertainPixel, 2> seen;
        bool is_seen = true;
        for (int k = 0; k < 2 && is_seen; ++k) {
          std::vector<double> values = model.free_values(rig.cameras[k].camera.camera.lens);
          for (int i = 0; i < 8; ++i) values[i] += error[12 + 8 * k + i];
          const Pose place = retract(rig.cameras[k].camera_from_rig, error.segment<6>(6 * k));
          const auto pixel = project(*model.lens(values, kRectifiedSize), place * x);
          is_seen = pixel && contains(kRectifiedSize, *pixel);
          if (is_seen)
            seen[k] = {*pixel + 0.1 * Vector2d(normal(), normal()), 0.01 * Matrix2::Identity()};
        }
        if (!is_seen) continue;
        ++count;
        const auto found = vertical_disparity(rig, pair, seen);
        ASSERT_TRUE(found);
        EXPECT_GT(found->sigma_px, found->sigma_of_rig_px);
        nees += std::pow(found->difference_px / found->sigma_px, 2);
      }
      EXPECT_NEAR(nees / count, 1, 0.12) << longlat << is_vertical;
    }
}

}  // namespace
}  // namespace tagcal
