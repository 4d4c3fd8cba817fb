#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "batch_fixture.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

template <typename L>
class BatchJacobiansOf : public testing::Test {};
using PolynomialLenses = testing::Types<Perspective, Fisheye, Parallel>;
TYPED_TEST_SUITE(BatchJacobiansOf, PolynomialLenses);

TYPED_TEST(BatchJacobiansOf, JacobiansAreTheChainOfThoseOfOnePoint) {
  Random random(7);
  for (const ProjectKernels* kernels : all_kernels()) {
    for (const Lens& lens : lenses<TypeParam>(8, 50)) {
      const Pose pose = some_pose(random);
      std::vector<Vector3d> points;
      for (int i = 0; i < 21; ++i) points.push_back(pose.inverse() * some_point(lens, random));
      const Result rows = run(*kernels, lens, pose, points, every_parameter(lens), true);
      std::visit(
          [&](const auto& l) {
            for (std::size_t i = 0; i < points.size(); ++i) {
              PointJacobian j;
              typename std::decay_t<decltype(l)>::ParameterJacobian by_parameters;
              const Vector3d turned = pose.rotation_matrix() * points[i];
              const auto pixel = l.project(turned + pose.translation(), &j, &by_parameters);
              ASSERT_EQ(pixel.has_value(), rows.valid[i] != 0);
              if (!pixel || pixel->norm() > 3e4) continue;  // beside a pole of a rational model
              Eigen::Matrix<double, 2, 6> by_pose;
              by_pose << -j * cross_matrix(turned), j;
              EXPECT_LT((rows.pose_rows(i) - by_pose).norm(), 1e-10 * by_pose.norm());
              EXPECT_LT((rows.parameter_rows(i) - by_parameters).norm(),
                        1e-10 * by_parameters.norm());
            }
          },
          lens);
    }
  }
}

TYPED_TEST(BatchJacobiansOf, JacobianByPoseAgreesWithDifferencesOfRetract) {
  Random random(9);
  const Lens lens = random_lens<TypeParam>(random);
  const Pose pose = some_pose(random);
  std::vector<Vector3d> points;
  for (int i = 0; i < 100; ++i)
    points.push_back(
        pose.inverse() *
        (0.9 * std::visit([&](const auto& l) { return point_inside(l, random); }, lens)));
  const Result rows = run(fastest_kernels(), lens, pose, points, {}, true);
  for (int k = 0; k < 6; ++k) {
    const double h = 1e-6;
    const Result ahead = run(fastest_kernels(), lens, retract(pose, h * Vector6d::Unit(k)), points);
    const Result behind =
        run(fastest_kernels(), lens, retract(pose, -h * Vector6d::Unit(k)), points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!ahead.valid[i] || !behind.valid[i]) continue;  // at the border of the domain
      const Vector2d difference = (ahead.pixels[i] - behind.pixels[i]) / (2 * h);
      const RowMajor j = rows.pose_rows(i);
      EXPECT_LT((difference - j.col(k)).norm(), 1e-5 * (1 + j.norm())) << i << " " << k;
    }
  }
}

TEST(BatchJacobians, ColumnsAreThoseOfTheModelsTiedOnesSummed) {
  Random random(10);
  for (const ProjectKernels* kernels : all_kernels()) {
    for (const Model& model : Model::all()) {
      Lens lens = random_lens<Perspective>(random);
      if (&model.kind() == &kind_of<Fisheye>()) lens = random_lens<Fisheye>(random);
      if (&model.kind() == &kind_of<Parallel>()) lens = random_lens<Parallel>(random);
      if (&model.kind() == &kind_of<DoubleSphere>()) lens = random_lens<DoubleSphere>(random);
      if (&model.kind() == &kind_of<ExtendedUnified>()) lens = random_lens<ExtendedUnified>(random);
      std::vector<Vector3d> points;
      for (int i = 0; i < 11; ++i) points.push_back(some_point(lens, random));
      std::vector<FreeParameter> free = model.free();
      std::reverse(free.begin(), free.end());  // any order
      const Result all = run(*kernels, lens, Pose(), points, every_parameter(lens));
      const Result some = run(*kernels, lens, Pose(), points, free);
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (!all.valid[i]) continue;
        for (std::size_t k = 0; k < free.size(); ++k) {
          Vector2d sum = Vector2d::Zero();
          for (const int index : free[k].lens_parameters) sum += all.parameter_rows(i).col(index);
          const Vector2d column = some.parameter_rows(i).col(static_cast<Eigen::Index>(k));
          EXPECT_LE((column - sum).norm(), 4 * std::numeric_limits<double>::epsilon() * sum.norm())
              << model.name() << " " << k;
        }
      }
    }
  }
}

TEST(BatchJacobians, DistortionThatIsZeroHasColumnsAllTheSame) {
  // A fit begins at zero: the columns must not be left out with the terms.
  const Lens lens = pinhole(500, 500, 320, 240);
  const std::vector<Vector3d> points = {{0.3, 0.4, 1}};
  for (const ProjectKernels* kernels : all_kernels()) {
    const std::vector<FreeParameter> k1 = {{"k1", {4}}};
    const RowMajor by_k1 = run(*kernels, lens, Pose(), points, k1).parameter_rows(0);
    EXPECT_NEAR(by_k1(0, 0), 500 * 0.3 * 0.25, 1e-12);
    const RowMajor j = run(*kernels, lens, Pose(), points, every_parameter(lens)).parameter_rows(0);
    EXPECT_NEAR(j(0, 4), 500 * 0.3 * 0.25, 1e-12);                  // k1: fx x s
    EXPECT_NEAR(j(1, 6), 500 * (0.25 + 2 * 0.16), 1e-12);           // p1: fy (s + 2 y^2)
    EXPECT_NEAR(j(1, 11), -500 * 0.4 * 0.25 * 0.25 * 0.25, 1e-12);  // k6: -fy y s^3
  }
}

// OpenCV's columns: rotation vector, translation, fx fy cx cy, k1 k2 p1 p2 k3 (k4 k5 k6).
TEST(BatchJacobians, AgreeWithOpenCV) {
  Random random(11);
  for (const ProjectKernels* kernels : all_kernels()) {
    for (int i = 0; i < 300; ++i) {
      const Perspective lens = random_lens<Perspective>(random);
      const auto& p = lens.parameters();
      const Vector3d turn(random.normal(), random.normal(), random.normal());
      const Pose pose(exp_rotation(turn), {random.normal(), random.normal(), random.normal()});
      const Vector3d point = pose.inverse() * point_inside(lens, random);
      const Result rows = run(*kernels, lens, pose, {{point}}, every_parameter(lens), true);
      if (!rows.valid[0] || rows.pixels[0].norm() > 3e3) continue;
      cv::Mat1d distortion(1, 8);
      for (int k = 0; k < 8; ++k) distortion(k) = p[static_cast<std::size_t>(k) + 4];
      std::vector<cv::Point2d> pixels;
      cv::Mat jacobian;
      cv::projectPoints(
          std::vector<cv::Point3d>{{point.x(), point.y(), point.z()}},
          cv::Vec3d(turn.x(), turn.y(), turn.z()),
          cv::Vec3d(pose.translation().x(), pose.translation().y(), pose.translation().z()),
          cv::Matx33d(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1), distortion, pixels, jacobian);
      RowMajor ours(2, 18);
      ours << rows.pose_rows(0), rows.parameter_rows(0);
      ours.leftCols<3>() = (ours.leftCols<3>() * left_jacobian(turn)).eval();
      const Eigen::Map<const RowMajor> theirs(jacobian.ptr<double>(), 2, 18);
      EXPECT_LT((rows.pixels[0] - Vector2d(pixels[0].x, pixels[0].y)).norm(), 1e-9);
      for (int k = 0; k < 18; ++k)
        EXPECT_LT((ours.col(k) - theirs.col(k)).norm(), 1e-9 * (1 + theirs.norm()))
            << i << " " << k;
    }
  }
}

TEST(BatchJacobians, OnlyWhatIsAskedForIsWritten) {
  const Lens lens = pinhole(500, 500, 320, 240);
  const std::vector<Vector3d> points(5, {0.1, 0.2, 1});
  const auto free = every_parameter(lens);
  for (const ProjectKernels* kernels : all_kernels()) {
    const Result both = run(*kernels, lens, Pose(), points, free, true);
    const Result pose = run(*kernels, lens, Pose(), points, {}, true);
    const Result parameters = run(*kernels, lens, Pose(), points, free);
    EXPECT_EQ(pose.by_pose, both.by_pose);
    EXPECT_EQ(parameters.by_parameters, both.by_parameters);
    EXPECT_EQ(pose.pixels, parameters.pixels);
    // Nothing is written behind the end.
    Result longer = both;
    longer.valid[3] = 77;
    longer.pixels[3].setConstant(kUntouched);
    std::fill(longer.by_pose.begin(), longer.by_pose.end(), kUntouched);
    std::fill(longer.by_parameters.begin(), longer.by_parameters.end(), kUntouched);
    const std::span<double> by_pose(longer.by_pose), by_parameters(longer.by_parameters);
    project_by(*kernels, lens, Pose(), std::span(points).first(3), free,
               {std::span(longer.pixels).first(3), std::span(longer.valid).first(3),
                by_pose.first(36), by_parameters.first(72)});
    EXPECT_EQ(longer.valid[3], 77);
    EXPECT_EQ(longer.pixels[3].x(), kUntouched);
    EXPECT_EQ(longer.by_pose[35], both.by_pose[35]);
    EXPECT_EQ(longer.by_pose[36], kUntouched);
    EXPECT_EQ(longer.by_parameters[71], both.by_parameters[71]);
    EXPECT_EQ(longer.by_parameters[72], kUntouched);
  }
}

TEST(BatchJacobians, WhatDoesNotFitIsAnError) {
  const Lens lens = Parallel({100, 100, 320, 240});
  const std::vector<Vector3d> points(3, {0.1, 0.2, 1});
  std::vector<Vector2d> pixels(3);
  std::vector<std::uint8_t> valid(3);
  std::vector<double> rows(36), many_rows(42);
  const auto with = [&](std::span<const FreeParameter> free, const ProjectionOutput& output) {
    return project_with_jacobians(lens, Pose(), points, free, output);
  };
  EXPECT_EQ(with({}, {pixels, valid, rows}), 3u);
  const std::span<Vector2d> all_pixels(pixels);
  const std::span<std::uint8_t> all_valid(valid);
  const std::span<double> all_rows(rows);
  EXPECT_THROW(with({}, {all_pixels.first(2), valid}), Error);
  EXPECT_THROW(with({}, {pixels, all_valid.first(2)}), Error);
  EXPECT_THROW(with({}, {pixels, valid, all_rows.first(35)}), Error);
  const std::vector<FreeParameter> cx = {{"cx", {2}}}, k1 = {{"k1", {6}}}, none = {{"none", {}}};
  EXPECT_EQ(with(cx, {pixels, valid, {}, all_rows.first(6)}), 3u);
  EXPECT_THROW(with(cx, {pixels, valid, {}, all_rows.first(5)}), Error);
  EXPECT_THROW(with(k1, {pixels, valid, {}, all_rows.first(6)}), Error);
  EXPECT_THROW(with(none, {pixels, valid, {}, all_rows.first(6)}), Error);
  EXPECT_THROW(with(std::vector<FreeParameter>(7, cx[0]), {pixels, valid, {}, many_rows}), Error);
  EXPECT_THROW(project(lens, Pose(), points, all_pixels.first(2), valid), Error);
  EXPECT_EQ(project(lens, Pose(), {}, {}, {}), 0u);
}

}  // namespace
}  // namespace tagcal
