#include "tagcal/geometry/transform.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <opencv2/calib3d.hpp>

#include "poses.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

Affine random_affine(Random& random) {
  const Vector3d factors(random.uniform(0.3, 2), random.uniform(-2, -0.3), random.uniform(0.3, 2));
  return random_pose(random) * scaling(factors) * shearing(Axis::x, Axis::z, random.normal());
}

void expect_same_matrix(const Matrix4d& a, const Matrix4d& b, double tolerance) {
  EXPECT_LE((a - b).cwiseAbs().maxCoeff(), tolerance) << a << "\nagainst\n" << b;
}

TEST(Rotation, AboutAnyAxisIsOpenCVsOn10000RandomCases) {
  Random random(1);
  double worst = 0;
  for (int i = 0; i < 10000; ++i) {
    const Vector3d axis = random_vector(random);
    const double angle = random.uniform(-2 * kPi, 2 * kPi);
    const Vector3d v = angle * axis.normalized();
    cv::Matx33d theirs;
    cv::Rodrigues(cv::Vec3d(v.x(), v.y(), v.z()), theirs);
    const Matrix3d ours = rotation_about_axis(axis, angle).rotation_matrix();
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(ours(r, c) - theirs(r, c)));
  }
  EXPECT_LT(worst, 4e-15);
}

TEST(Rotation, AboutTheThreeAxesTurnsRightHanded) {
  EXPECT_LT((rotation_about_x(kPi / 2) * Vector3d::UnitY() - Vector3d::UnitZ()).norm(), 1e-15);
  EXPECT_LT((rotation_about_y(kPi / 2) * Vector3d::UnitZ() - Vector3d::UnitX()).norm(), 1e-15);
  EXPECT_LT((rotation_about_z(kPi / 2) * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-15);
}

TEST(Rotation, AboutATinyAxis) {
  expect_same_matrix(rotation_about_axis({1e-200, 0, 0}, 0.3).matrix(),
                     rotation_about_x(0.3).matrix(), 0);
}

TEST(Rotation, AboutALineHoldsItsPointsAndMovesOthersAroundThem) {
  const Vector3d point(1, 2, 3), axis(0, 0, -2);
  const Pose turn = rotation_about_line(point, axis, kPi / 2);
  EXPECT_LT((turn * point - point).norm(), 1e-15);
  EXPECT_LT((turn * (point + 7 * axis) - (point + 7 * axis)).norm(), 1e-14);
  EXPECT_LT((turn * (point + Vector3d::UnitX()) - (point - Vector3d::UnitY())).norm(), 1e-15);
}

TEST(Rotation, RotationsDoNotCommuteAndTranslationsDo) {
  const Pose x90 = rotation_about_x(kPi / 2), y90 = rotation_about_y(kPi / 2);
  // The z axis: x90 takes it to -y, which y90 leaves; y90 takes it to x, which x90 leaves.
  EXPECT_LT((y90 * x90 * Vector3d::UnitZ() - Vector3d(0, -1, 0)).norm(), 1e-15);
  EXPECT_LT((x90 * y90 * Vector3d::UnitZ() - Vector3d(1, 0, 0)).norm(), 1e-15);
  const Pose a = translation({1, 2, 3}), b = translation({-4, 0.5, 9});
  expect_same_matrix((a * b).matrix(), (b * a).matrix(), 0);
}

// The worked numbers of "rotation about [1, 1, 1]".
TEST(Alignment, OfTheDiagonalWithXByTwoTurnsHasTheKnownRows) {
  const Pose turns = aligning_with_x({1, 1, 1});
  expect_same_matrix(
      turns.matrix(),
      (rotation_about_z(-std::atan(std::sqrt(2.0))) * rotation_about_x(-kPi / 4)).matrix(), 1e-15);
  Matrix3d rows;
  rows.row(0) = Vector3d(1, 1, 1) / std::sqrt(3.0);
  rows.row(1) = std::sqrt(2.0 / 3) * Vector3d(-1, 0.5, 0.5);
  rows.row(2) = Vector3d(0, -1, 1) / std::sqrt(2.0);
  EXPECT_LT((turns.rotation_matrix() - rows).norm(), 1e-15);
}

// The second method of the same lecture, with its numbers, and how it differs from the first.
TEST(Alignment, OfTheDiagonalWithXByRowsHasTheKnownRows) {
  const Pose by_rows = aligning_with_x({1, 1, 1}, {1, 0, 0});
  Matrix3d rows;
  rows.row(0) = Vector3d(1, 1, 1) / std::sqrt(3.0);
  rows.row(1) = Vector3d(0, 1, -1) / std::sqrt(2.0);
  rows.row(2) = Vector3d(-2, 1, 1) / std::sqrt(6.0);
  EXPECT_LT((by_rows.rotation_matrix() - rows).norm(), 1e-15);
  expect_same_matrix(
      by_rows.matrix(),
      (rotation_about_y(std::atan(std::sqrt(2.0))) * rotation_about_x(kPi / 4)).matrix(), 1e-15);
  expect_same_matrix((aligning_with_x({1, 1, 1}) * by_rows.inverse()).matrix(),
                     rotation_about_x(-kPi / 2).matrix(), 1e-15);
}

TEST(Alignment, BothWaysGiveTheSameRotationAboutTheAxisAndDifferByATurnAboutX) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Vector3d axis = i == 0 ? Vector3d(1, 1, 1) : random_vector(random);
    const double angle = random.uniform(-kPi, kPi);
    const Pose one = aligning_with_x(axis), other = aligning_with_x(axis, random_vector(random));
    const Pose about_axis = rotation_about_axis(axis, angle);
    for (const Pose& aligning : {one, other}) {
      EXPECT_LT((aligning * axis - Vector3d(axis.norm(), 0, 0)).norm(), 2e-15 * axis.norm());
      const Pose there_and_back = aligning.inverse() * rotation_about_x(angle) * aligning;
      expect_same_matrix(there_and_back.matrix(), about_axis.matrix(), 4e-15);
    }
    const Pose difference = other * one.inverse();
    EXPECT_GT(angle_between_rad(one, other), 1e-3);  // two alignments, not one
    EXPECT_LT((difference * Vector3d::UnitX() - Vector3d::UnitX()).norm(), 2e-15);
  }
}

TEST(Alignment, OfTheAxesThemselves) {
  for (int k = 0; k < 3; ++k) {
    for (const double sign : {1.0, -1.0}) {
      const Vector3d axis = sign * Vector3d::Unit(k);
      EXPECT_LT((aligning_with_x(axis) * axis - Vector3d::UnitX()).norm(), 1e-15);
      const Pose by_rows = aligning_with_x(axis, Vector3d::Unit((k + 1) % 3));
      EXPECT_LT((by_rows * Vector3d::Unit((k + 1) % 3) + Vector3d::UnitZ()).norm(), 1e-15);
    }
  }
}

// A unit square, rotated by 30 degrees, moved by [2, 1], and the same stretched by 2 in y before
// and after.
TEST(Affine, ASquareStretchedBeforeIsNotTheSquareStretchedAfter) {
  const Pose moved = translation({2, 1, 0}) * rotation_about_z(kPi / 6);
  const Affine stretched = scaling({1, 2, 1});
  const Vector3d corner(1, 1, 0);
  const double c = std::sqrt(3.0) / 2, s = 0.5;
  EXPECT_LT((moved * corner - Vector3d(2 + c - s, 1 + s + c, 0)).norm(), 1e-15);
  EXPECT_LT((moved * stretched * corner - Vector3d(2 + c - 2 * s, 1 + s + 2 * c, 0)).norm(), 1e-15);
  EXPECT_LT((stretched * moved * corner - Vector3d(2 + c - s, 2 * (1 + s + c), 0)).norm(), 1e-15);
  // Stretched before it is a rectangle, after it a rhomboid.
  const Matrix3d before = (moved * stretched).linear(), after = (stretched * moved).linear();
  EXPECT_NEAR(before.col(0).dot(before.col(1)), 0, 1e-15);
  EXPECT_NEAR(after.col(0).dot(after.col(1)), 3 * c * s, 1e-15);
}

TEST(Affine, OfRowVectorsIsTheTransposeInTheOtherOrder) {
  const Affine a = scaling({1, 2, 3}), b = affine(translation({4, 5, 6}));
  const Matrix4d m_a = a.matrix().transpose(), m_b = b.matrix().transpose();
  const Eigen::RowVector4d x(0.3, 0.2, 0.1, 1);
  const Vector4d ours = (b * a).matrix() * x.transpose();
  EXPECT_EQ((x * m_a * m_b).transpose(), ours);
}

// T R keeps the translation in the last column, R T has it turned: its products with R's rows.
TEST(Affine, ATranslationAfterARotationIsKeptAndBeforeItIsTurned) {
  const Pose r = rotation_about_z(std::atan2(3, 4)), t = translation({5, 10, 15});
  EXPECT_EQ((t * r).translation(), Vector3d(5, 10, 15));
  EXPECT_LT(((r * t).translation() - Vector3d(-2, 11, 15)).norm(), 1e-14);
  for (const Pose& both : {t * r, r * t})
    EXPECT_LT((both.rotation_matrix() - r.rotation_matrix()).norm(), 1e-15);
}

TEST(Affine, ShearMovesOneCoordinateByAnother) {
  EXPECT_EQ(shearing(Axis::x, Axis::z, 0.5) * Vector3d(1, 2, 4), Vector3d(3, 2, 4));
  EXPECT_EQ(shearing(Axis::z, Axis::y, -2) * Vector3d(1, 2, 4), Vector3d(1, 2, 0));
}

TEST(Affine, ComposesWithPosesAndHasAnInverse) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Affine a = random_affine(random);
    const Pose b = random_pose(random);
    expect_same_matrix((a * b).matrix(), a.matrix() * b.matrix(), 1e-14);
    expect_same_matrix((b * a).matrix(), b.matrix() * a.matrix(), 1e-14);
    expect_same_matrix((inverse_of(a) * a).matrix(), Matrix4d::Identity(), 1e-13);
    expect_same_matrix(rigid(affine(b)).matrix(), b.matrix(), 2e-15);
  }
}

TEST(Affine, OnlyARigidOneIsAPose) {
  EXPECT_THROW(rigid(scaling({1, 1, 1 + 1e-8})), Error);
  EXPECT_THROW(rigid(scaling({1, 1, -1})), Error);
  EXPECT_THROW(rigid(shearing(Axis::x, Axis::y, 1e-8)), Error);
}

TEST(Affine, AShadowHasNoInverseAndAStrongStretchHas) {
  EXPECT_THROW(inverse_of(scaling({1, 1, 0})), Error);
  EXPECT_THROW(inverse_of(rotation_about_axis({1, 2, 3}, 1) * scaling({0, 1, 1})), Error);
  expect_same_matrix(inverse_of(scaling({1e-6, 1, 1e4})).matrix(), scaling({1e6, 1, 1e-4}).matrix(),
                     1e-9);
}

TEST(PolarCoordinates, OfKnownPoints) {
  EXPECT_LT((cartesian_from_polar({2, kPi / 6}) - Vector2d(std::sqrt(3.0), 1)).norm(), 1e-15);
  EXPECT_EQ(polar_from_cartesian({-3, -0.0}).theta_rad, kPi);
  // theta from +z, phi from +x about z
  EXPECT_LT(
      (cartesian_from_spherical({2, kPi / 3, kPi / 2}) - Vector3d(0, std::sqrt(3.0), 1)).norm(),
      1e-15);
  const Spherical below = spherical_from_cartesian({-0.0, 0, -3});
  EXPECT_EQ(below.rho, 3);
  EXPECT_EQ(below.theta_rad, kPi);
  EXPECT_EQ(below.phi_rad, 0);
  const Spherical origin = spherical_from_cartesian({0, -0.0, -0.0});
  EXPECT_EQ(origin.rho + origin.theta_rad + origin.phi_rad, 0);
}

TEST(PolarCoordinates, ThereAndBack) {
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d x = std::pow(10, random.uniform(-100, 100)) * random_vector(random);
    EXPECT_LT((cartesian_from_spherical(spherical_from_cartesian(x)) - x).norm() / x.norm(), 1e-15);
    const Vector2d y = x.head<2>();
    EXPECT_LT((cartesian_from_polar(polar_from_cartesian(y)) - y).norm() / y.norm(), 1e-15);
  }
}

TEST(Cofactors, AreTheDeterminantTimesTheInverseTranspose) {
  Random random(5);
  for (int i = 0; i < 100; ++i) {
    const Matrix4d m = Matrix4d::NullaryExpr([&] { return random.normal(); });
    EXPECT_LT((cofactor_matrix(m).transpose() * m - m.determinant() * Matrix4d::Identity()).norm(),
              1e-12);
    const Matrix3d l = m.topLeftCorner<3, 3>();
    const Vector3d u = random_vector(random), v = random_vector(random);
    EXPECT_LT(((l * u).cross(l * v) - cofactor_matrix(l) * u.cross(v)).norm(), 1e-12);
  }
}

Vector4d plane_through(const Vector3d& point, const Vector3d& normal) {
  return {normal.x(), normal.y(), normal.z(), -normal.dot(point)};
}

TEST(Plane, GoesByTheInverseTransposeAndKeepsItsSides) {
  Random random(6);
  for (int i = 0; i < 200; ++i) {
    const Affine m = random_affine(random);  // it mirrors
    const Vector3d normal = random_vector(random), point = random_vector(random);
    const Vector4d plane = plane_through(point, normal);
    const Vector4d image = transformed_plane(m.matrix(), plane);
    EXPECT_NEAR(image.head<3>().norm(), 1, 1e-14);
    const Vector4d by_definition = m.matrix().inverse().transpose() * plane;
    EXPECT_LT((image - by_definition / by_definition.head<3>().norm()).norm(), 1e-12);
    const Vector3d inside = point + normal.unitOrthogonal(), above = point + normal;
    EXPECT_NEAR(image.dot((m * inside).homogeneous()), 0, 1e-12);
    EXPECT_GT(image.dot((m * above).homogeneous()), 0);
  }
}

TEST(Plane, AStretchTiltsItUnlikeAPoint) {
  // x + y = 1 stretched by 2 in x passes through (2, 0) and (0, 1): x / 2 + y = 1.
  const Vector4d image = transformed_plane(scaling({2, 1, 1}).matrix(), {1, 1, 0, -1});
  EXPECT_LT((image - Vector4d(1, 2, 0, -2) / std::sqrt(5.0)).norm(), 1e-15);
}

TEST(Plane, OfASingularMatrixGoesByTheCofactors) {
  // The shadow on the ground: every plane that is not seen edge on becomes the ground.
  const Affine shadow = rotation_about_x(0.4) * scaling({1, 1, 0});
  const Vector3d ground_normal = rotation_about_x(0.4) * Vector3d::UnitZ();
  const Vector4d image = transformed_plane(shadow.matrix(), {0.3, -0.2, 0.5, 7});
  EXPECT_LT(image.head<3>().cross(ground_normal).norm(), 1e-14);
  EXPECT_NEAR(image(3), 0, 1e-14);
  EXPECT_THROW(transformed_plane(shadow.matrix(), {1, 2, 0, 3}), Error);  // edge on: a line
}

TEST(Plane, OfAProjectiveMatrix) {
  Matrix4d m = Matrix4d::Identity();
  m.row(3) = Vector4d(0, 0, 1, 0);  // z = 0 goes to infinity
  EXPECT_THROW(transformed_plane(m + Matrix4d(Vector4d(0, 0, 0, 1).asDiagonal()), {0, 0, 0, 1}),
               Error);
  m.row(2) = Vector4d(0, 0, 0, 1);  // (x, y, z) -> (x/z, y/z, 1/z)
  EXPECT_THROW(transformed_plane(m, {0, 0, 1, 0}), Error);
  const Vector4d image = transformed_plane(m, {0, 0, 1, -4});
  EXPECT_LT((image / image(2) - Vector4d(0, 0, 1, -0.25)).norm(), 1e-15);
}

TEST(Line, GoesWhereItsPointsGo) {
  Random random(7);
  const Affine m = random_affine(random);
  const Line line{random_vector(random), random_vector(random)};
  const Line image = transformed_line(m, line);
  const Vector3d on_line = m * Vector3d(line.a + 1.7 * (line.b - line.a));
  EXPECT_LT((on_line - (image.a + 1.7 * (image.b - image.a))).norm(), 1e-14);
  EXPECT_THROW(transformed_line(m, {line.a, line.a}), Error);
  EXPECT_THROW(transformed_line(scaling({1, 1, 0}), {{1, 2, 3}, {1, 2, 4}}), Error);
}

TEST(Transform, NumbersThatAreNoneAndAxesOfNoLengthAreErrors) {
  const Vector3d bad(0, kNan, 0), good(1, 2, 3);
  EXPECT_THROW(translation(bad), Error);
  EXPECT_THROW(rotation_about_x(kNan), Error);
  EXPECT_THROW(rotation_about_axis(good, kInfinity), Error);
  EXPECT_THROW(rotation_about_axis(bad, 1), Error);
  EXPECT_THROW(rotation_about_axis({0, 0, 0}, 1), Error);
  EXPECT_THROW(rotation_about_line(bad, good, 1), Error);
  EXPECT_THROW(scaling(kInfinity), Error);
  EXPECT_THROW(shearing(Axis::x, Axis::y, kNan), Error);
  EXPECT_THROW(shearing(Axis::x, Axis::x, 1), Error);
  EXPECT_THROW(aligning_with_x({0, 0, 0}), Error);
  EXPECT_THROW(aligning_with_x(good, -2 * good), Error);
  EXPECT_THROW(polar_from_cartesian({kNan, 0}), Error);
  EXPECT_THROW(cartesian_from_polar({1, kInfinity}), Error);
  EXPECT_THROW(spherical_from_cartesian(bad), Error);
  EXPECT_THROW(cartesian_from_spherical({1, 2, kNan}), Error);
  EXPECT_THROW(transformed_plane(Matrix4d::Identity(), {0, 0, 0, 1}), Error);
  EXPECT_THROW(transformed_plane(Matrix4d::Identity(), {1, 0, 0, kNan}), Error);
  EXPECT_THROW(transformed_line(scaling(1), {good, bad}), Error);
}

}  // namespace
}  // namespace tagcal
