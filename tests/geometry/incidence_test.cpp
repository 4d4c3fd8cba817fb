#include "tagcal/geometry/transform.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tagcal/error.hpp"
#include "tagcal/random.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector4d;

Vector4d random_point(Random& random) {
  return {random.normal(), random.normal(), random.normal(), random.uniform(-1, 1)};
}

TEST(Incidence, WhatIsJoinedLiesOnThePlaneAndWhatMeetsOnAllThree) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Vector4d a = random_point(random), b = random_point(random), c = random_point(random);
    const Vector4d plane = join(a, b, c), point = meet(a, b, c);
    EXPECT_NEAR(plane.norm(), 1, 1e-15);
    for (const Vector4d& x : {a, b, c}) {
      EXPECT_LT(std::abs(plane.dot(x)), 1e-14 * x.norm());
      EXPECT_LT(std::abs(point.dot(x)), 1e-14 * x.norm());
    }
  }
  EXPECT_TRUE(
      join({1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}).isApprox(Vector4d(-1, -1, -1, 1) / 2, 1e-15) ||
      join({1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}).isApprox(Vector4d(1, 1, 1, -1) / 2, 1e-15));
  EXPECT_THROW(join({1, 0, 0, 1}, {2, 0, 0, 1}, {3, 0, 0, 1}), Error);  // on a line
}

TEST(Incidence, TwoPlanesMeetInALineAndALineMeetsAPlane) {
  const Line line = meet(Vector4d(0, 0, 1, -2), Vector4d(0, 3, 0, -3));  // z = 2, y = 1
  EXPECT_LT((line.a - Vector3d(0, 1, 2)).norm(), 1e-15);
  EXPECT_LT((line.b - line.a).cross(Vector3d::UnitX()).norm(), 1e-15);
  EXPECT_NEAR((line.b - line.a).norm(), 1, 1e-15);
  EXPECT_LT((meet(line, {1, 0, 0, -5}).hnormalized() - Vector3d(5, 1, 2)).norm(), 1e-14);
  EXPECT_NEAR(meet(line, {0, 1, 0, -5}).w(), 0, 1e-15);  // parallel: a point at infinity
  EXPECT_THROW(meet(line, Vector4d(0, 0, 1, -2)), Error);
  EXPECT_THROW(meet(Vector4d(0, 0, 1, -2), Vector4d(0, 0, 2, 3)), Error);
  const Vector4d plane = join(line, {0, 0, 0, 1});
  EXPECT_LT(std::abs(plane.dot(line.a.homogeneous())), 1e-15);
  EXPECT_EQ(plane.w(), 0);
}

TEST(Incidence, ALineMeetsAPlaneAtTUV) {
  const Line line{{0, 0, 4}, {0, 0, 2}};
  const auto m = meeting(line, {1, 1, 0}, {2, 0, 0}, {0, 4, 0});
  ASSERT_TRUE(m);
  EXPECT_EQ(m->t, 2);
  EXPECT_EQ(m->u, -0.5);
  EXPECT_EQ(m->v, -0.25);
  EXPECT_FALSE(meeting(line, {1, 1, 0}, {0, 0, 1}, {0, 4, 0}));
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const auto vector = [&] { return Vector3d(random.normal(), random.normal(), random.normal()); };
    const Line l{vector(), vector()};
    const Vector3d w = vector(), u = vector(), v = vector();
    const auto x = meeting(l, w, u, v);
    if (!x) continue;
    const double size = 1 + std::abs(x->t) + std::abs(x->u) + std::abs(x->v);
    EXPECT_LT((l.a + x->t * (l.b - l.a) - (w + x->u * u + x->v * v)).norm(), 1e-11 * size);
  }
}

TEST(Incidence, FiveMatchingsGiveTheMap) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    Matrix4d truth;
    for (double& entry : truth.reshaped()) entry = random.normal();
    if (std::abs(truth.determinant()) < 0.1) continue;
    FivePoints source, target;
    for (std::size_t k = 0; k < 5; ++k) {
      source[k] = random_point(random);
      target[k] = random.uniform(-3, 3) * truth * source[k];
    }
    const Matrix4d map = projective_map(source, target);
    const double sign = map.reshaped().dot(truth.reshaped()) < 0 ? -1 : 1;
    EXPECT_LT((map - sign * truth / truth.norm()).norm(), 1e-7);
  }
  FivePoints flat = {Vector4d(1, 0, 0, 1), {0, 1, 0, 1}, {0, 0, 0, 1}, {1, 1, 0, 1}, {0, 0, 1, 1}};
  EXPECT_THROW(projective_map(flat, flat), Error);
}

// The perspective of a lecture: the five corners of a symmetric view volume fix the 16 unknowns.
TEST(Incidence, TheCornersOfAFrustumGiveItsMatrix) {
  const double k = 0.25;  // near / far; sides at 45 degrees, looking along -z
  const FivePoints source = {
      Vector4d(k, k, -k, 1), {-k, k, -k, 1}, {k, -k, -k, 1}, {1, 1, -1, 1}, {-1, 1, -1, 1}};
  const FivePoints target = {
      Vector4d(1, 1, 0, 1), {-1, 1, 0, 1}, {1, -1, 0, 1}, {1, 1, -1, 1}, {-1, 1, -1, 1}};
  // (1, 1), (-1, 1) near and far are in a plane: the fifth corner must leave it.
  EXPECT_THROW(projective_map(source, target), Error);
  FivePoints better = source, image = target;
  better[4] = {-1, -1, -1, 1};
  image[4] = {-1, -1, -1, 1};
  Matrix4d expected = Matrix4d::Identity();
  expected(2, 2) = 1 / (1 - k);
  expected(2, 3) = k / (1 - k);
  expected(3, 2) = -1;
  expected(3, 3) = 0;
  const Matrix4d map = projective_map(better, image);
  EXPECT_LT((map / map(0, 0) - expected).norm(), 1e-14);
}

TEST(Incidence, LinesAndConicsGoThroughAProjection) {
  Matrix3d h;
  h << 2, 0.1, 3, -0.2, 1.5, 1, 0.01, 0.02, 1;
  const Vector3d p(1, 2, 1), q(-1, 0.5, 1);
  const Vector3d line = transformed_line(h, p.cross(q));
  EXPECT_LT(std::abs(line.dot(h * p)), 1e-14);
  EXPECT_LT(std::abs(line.dot(h * q)), 1e-14);
  const Matrix3d circle = conic(1, 0, 1, -2, -4, 1);  // radius 2 about (1, 2)
  const Matrix3d image = transformed_conic(h, circle);
  Projection34 projection;
  projection << h.leftCols<2>(), Vector3d(0.3, -0.4, 5), h.col(2);  // H on the plane z = 0
  for (int i = 0; i < 8; ++i) {
    const double turn = i * std::numbers::pi / 4;
    const Vector3d x(1 + 2 * std::cos(turn), 2 + 2 * std::sin(turn), 1);
    EXPECT_LT(std::abs(x.dot(circle * x)), 1e-14);
    const Vector3d y = h * x;
    EXPECT_LT(std::abs(y.dot(image * y)), 1e-12);
    const Vector4d in_space(x.x(), x.y(), 0, 1);
    EXPECT_LT(std::abs(in_space.dot(cone_of_image_conic(projection, image) * in_space)), 1e-12);
  }
  const Vector4d plane = plane_of_image_line(projection, line);
  EXPECT_LT(std::abs(plane.dot(Vector4d(1, 2, 0, 1))), 1e-14);
  EXPECT_THROW(transformed_line(Matrix3d::Zero(), p), Error);
}

}  // namespace
}  // namespace tagcal
