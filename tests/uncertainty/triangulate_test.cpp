#include "tagcal/uncertainty/triangulate.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/random.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr ImageSize kTriangulatedSize = {1280, 800};

// Three cameras beside one another; the last one has a fisheye.
KnownRig three_cameras() {
  const Lens a = Perspective({900, 901, 640, 400, -0.1, 0.05, 0, 0, 0, 0, 0, 0});
  const Lens b = Fisheye({420, 420, 639, 402, 0.02, -0.01, 0.003, -0.0005});
  KnownRig rig;
  rig.cameras.push_back(
      {"left", {&Model::named("opencv4"), {a, kTriangulatedSize}, {}}, {}, std::nullopt});
  rig.cameras.push_back({"right",
                         {&Model::named("opencv4"), {a, kTriangulatedSize}, {}},
                         Pose(exp_rotation({0.02, -0.03, 0.01}), {-0.3, 0.01, 0.02}),
                         std::nullopt});
  rig.cameras.push_back({"wide",
                         {&Model::named("fisheye4"), {b, kTriangulatedSize}, {}},
                         Pose(exp_rotation({-0.1, 0.05, 0.2}), {-0.1, 0.2, 0.0}),
                         std::nullopt});
  return rig;
}

// What the cameras see of a point if places and lenses differ from the rig's by `error`; empty if
// one does not see it.
std::vector<SeenPixel> seen_by(const KnownRig& rig, const Vector3d& x, double sigma_px,
                               const Eigen::VectorXd& error, Random& random) {
  std::vector<SeenPixel> seen;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const KnownRig::Member& member = rig.cameras[c];
    Pose place = member.camera_from_rig;
    Lens lens = member.camera.camera.lens;
    if (error.size() > 0) {
      place = retract(place, error.segment<6>(6 * static_cast<Eigen::Index>(c)));
      std::vector<double> values = member.camera.model->free_values(lens);
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] += error[rig.first_of_lens(c) + static_cast<Eigen::Index>(i)];
      lens = member.camera.model->lens(values, kTriangulatedSize).value();
    }
    const auto pixel = project(lens, place * x);
    if (!pixel || !contains(kTriangulatedSize, *pixel)) return {};
    seen.push_back({c,
                    {*pixel + sigma_px * Vector2d(random.normal(), random.normal()),
                     sigma_px * sigma_px * Matrix2::Identity()}});
  }
  return seen;
}

Vector3d point_at(double z, Random& random) {
  return {z * random.uniform(-0.4, 0.4), z * random.uniform(-0.3, 0.3), z};
}

TEST(Triangulate, FindsTheTruthWithoutNoise) {
  const KnownRig rig = three_cameras();
  Random random(1, 0);
  int count = 0;
  for (const double z : {0.3, 1.0, 10.0, 30.0})
    for (int i = 0; i < 50; ++i) {
      const Vector3d x = point_at(z, random);
      std::vector<SeenPixel> seen = seen_by(rig, x, 0, {}, random);
      if (seen.empty()) continue;
      for (const std::size_t n : {3, 2}) {
        seen.resize(n);
        const TriangulatedPoint found = triangulate(rig, seen);
        ASSERT_EQ(found.status, TriangulationStatus::ok) << z;
        EXPECT_LT((found.point.x - x).norm(), 1e-8 * z * z);
        EXPECT_LT(found.rms_px, 1e-8);
        EXPECT_TRUE(found.contradicting.empty());
      }
      ++count;
    }
  EXPECT_GT(count, 100);
}

// Truths drawn from the joint covariance of places and lenses, and the noise of the pixels.
TEST(Triangulate, TheCovarianceHolds) {
  KnownRig rig = three_cameras();
  Random random(2, 0);
  const auto normal = [&] { return random.normal(); };
  const Eigen::Index size = rig.first_of_lens(3);
  Eigen::VectorXd scale(size);
  scale.head<18>().setConstant(3e-4);
  for (std::size_t c = 0; c < 3; ++c)
    scale.segment<8>(rig.first_of_lens(c)) << 0.5, 0.5, 0.4, 0.4, 1e-3, 1e-3, 1e-4, 1e-4;
  scale.tail<2>().setConstant(1e-4);
  Eigen::MatrixXd mix = Eigen::MatrixXd::NullaryExpr(size, size, normal) / 10;
  mix += Eigen::MatrixXd::Identity(size, size);
  const Eigen::MatrixXd root = scale.asDiagonal() * mix;
  rig.covariance = root * root.transpose();
  for (const double z : {0.3, 1.0, 3.0, 10.0, 30.0})
    for (const std::size_t n : {2, 3}) {
      double nees = 0, chi_square = 0;
      int count = 0, contradicting = 0;
      while (count < 2000) {
        const Vector3d x = point_at(z, random);
        const Eigen::VectorXd error = root * Eigen::VectorXd::NullaryExpr(size, normal);
        std::vector<SeenPixel> seen = seen_by(rig, x, 0.2, error, random);
        if (seen.empty()) continue;
        seen.resize(n);
        const TriangulatedPoint found = triangulate(rig, seen);
        if (found.status == TriangulationStatus::far && z > 20) continue;
        ASSERT_EQ(found.status, TriangulationStatus::ok) << z;
        const Vector3d off = found.point.x - x;
        nees += off.dot(found.point.covariance.inverse() * off) / 3;
        chi_square += found.chi_square / (2 * static_cast<double>(n) - 3);
        contradicting += !found.contradicting.empty();
        ++count;
      }
      EXPECT_GT(nees / count, 0.85) << z << " m, " << n;
      EXPECT_LT(nees / count, 1.1) << z << " m, " << n;
      EXPECT_NEAR(chi_square / count, 1, 0.12) << z << " m, " << n;
      EXPECT_LT(contradicting, 15) << z << " m, " << n;
    }
}

TEST(Triangulate, NamesTheCameraThatContradicts) {
  const KnownRig rig = three_cameras();
  Random random(3, 0);
  for (std::size_t wrong = 0; wrong < 3; ++wrong) {
    std::vector<SeenPixel> seen = seen_by(rig, {0.2, 0.1, 2}, 0.2, {}, random);
    ASSERT_FALSE(seen.empty());
    seen[wrong].at.pixel += Vector2d(7, 7);
    const TriangulatedPoint found = triangulate(rig, seen);
    EXPECT_EQ(found.contradicting, std::vector<std::size_t>{wrong});
    EXPECT_GT(found.chi_square, 50);
  }
  std::vector<SeenPixel> two = seen_by(rig, {0.2, 0.1, 2}, 0.2, {}, random);
  two.resize(2);
  two[1].at.pixel += Vector2d(0, 5);
  EXPECT_EQ(triangulate(rig, two).contradicting, (std::vector<std::size_t>{0, 1}));
}

TEST(Triangulate, HasNoPointWhereTheRaysDetermineNone) {
  const KnownRig rig = three_cameras();
  Random random(4, 0);
  EXPECT_EQ(triangulate(rig, {}).status, TriangulationStatus::few_cameras);
  std::vector<SeenPixel> seen = seen_by(rig, {100, 50, 3000}, 0.2, {}, random);
  EXPECT_EQ(triangulate(rig, seen).status, TriangulationStatus::far);
  EXPECT_EQ(triangulate(rig, std::span(seen).first(1)).status, TriangulationStatus::few_cameras);
  // A disparity of the wrong sign.
  seen = seen_by(rig, {0.1, 0.1, 2}, 0, {}, random);
  seen.resize(2);
  seen[1].at.pixel.x() += 300;
  EXPECT_EQ(triangulate(rig, seen).status, TriangulationStatus::behind);
  seen.push_back({2, {{5000, 5000}, Matrix2::Identity()}});
  EXPECT_EQ(triangulate(rig, seen).status, TriangulationStatus::no_ray);
}

TEST(Triangulate, RefusesWhatDoesNotFitTheRig) {
  KnownRig rig = three_cameras();
  Random random(5, 0);
  std::vector<SeenPixel> seen = seen_by(rig, {0.2, 0.1, 2}, 0.2, {}, random);
  seen[2].camera = 1;
  EXPECT_THROW(triangulate(rig, seen), Error);
  seen[2].camera = 3;
  EXPECT_THROW(triangulate(rig, seen), Error);
  seen[2].camera = 2;
  rig.covariance = MatrixX::Zero(3, 3);
  EXPECT_THROW(triangulate(rig, seen), Error);
  rig.covariance.resize(0, 0);
  rig.cameras[2].camera = {nullptr, {Parallel({100, 100, 0, 0, 0, 0}), kTriangulatedSize}, {}};
  EXPECT_THROW(triangulate(rig, seen), Error);
}

}  // namespace
}  // namespace tagcal
