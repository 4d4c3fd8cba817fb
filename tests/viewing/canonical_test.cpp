#include "tagcal/viewing/canonical.hpp"

#include <gtest/gtest.h>

#include "poses.hpp"
#include "tagcal/error.hpp"
#include "tagcal/viewing/projection.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;

const ViewVolume kFrustum{Projection::perspective, {-0.3, 0.5, -0.2, 0.4}, 0.6, 2};
const ViewVolume kBox{Projection::parallel, {-3, 5, -2, 4}, 1, 9};

ViewVolume random_volume(Random& random, Projection projection) {
  const double left = random.uniform(-3, 3), bottom = random.uniform(-3, 3);
  const double near = random.uniform(0.01, 2);
  return {projection,
          {left, left + random.uniform(0.1, 4), bottom, bottom + random.uniform(0.1, 4)},
          near,
          near * random.uniform(1.5, 1000)};
}

TEST(ClipFromEye, IsGlFrustum) {
  const double l = -0.3, r = 0.5, b = -0.2, t = 0.4, n = 0.6, f = 2;
  Matrix4d gl_frustum;                                     // as its manual page defines it
  gl_frustum << 2 * n / (r - l), 0, (r + l) / (r - l), 0,  //
      0, 2 * n / (t - b), (t + b) / (t - b), 0,            //
      0, 0, -(f + n) / (f - n), -2 * f * n / (f - n),      //
      0, 0, -1, 0;
  EXPECT_TRUE(clip_from_eye(kFrustum).isApprox(gl_frustum, 1e-15));
}

TEST(ClipFromEye, IsGlOrtho) {
  const double l = -3, r = 5, b = -2, t = 4, n = 1, f = 9;
  Matrix4d gl_ortho;
  gl_ortho << 2 / (r - l), 0, 0, -(r + l) / (r - l),  //
      0, 2 / (t - b), 0, -(t + b) / (t - b),          //
      0, 0, -2 / (f - n), -(f + n) / (f - n),         //
      0, 0, 0, 1;
  EXPECT_TRUE(clip_from_eye(kBox).isApprox(gl_ortho, 1e-15));
}

TEST(ClipFromEye, TakesTheCornersOfTheVolumeToThoseOfTheCube) {
  const std::vector<Vector3d> square = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  for (const ViewVolume& volume : {kFrustum, kBox}) {
    const std::vector<Vector3d> eight = corners(volume);
    ASSERT_EQ(eight.size(), 8u);
    EXPECT_TRUE(eight[0].isApprox(
        Vector3d(volume.window.left, volume.window.bottom, -volume.near_m), 1e-15));
    for (std::size_t i = 0; i < 8; ++i) {
      const bool near = i < 4;
      const Vector3d opengl = square[i % 4] + Vector3d(0, 0, near ? -1 : 1);
      const Vector3d phigs = square[i % 4] + Vector3d(0, 0, near ? 0 : -1);
      const auto x = eight[i].homogeneous();
      const auto gl = divided(clip_from_eye(volume, CanonicalVolume::opengl) * x);
      const auto ph = divided(clip_from_eye(volume, CanonicalVolume::phigs) * x);
      EXPECT_LT((gl.value() - opengl).norm(), 1e-14);
      EXPECT_LT((ph.value() - phigs).norm(), 1e-14);
    }
  }
}

TEST(ClipFromEye, IsTheProductOfItsSteps) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    for (const Projection projection : {Projection::perspective, Projection::parallel}) {
      for (const CanonicalVolume canonical : {CanonicalVolume::opengl, CanonicalVolume::phigs}) {
        const ViewVolume volume = random_volume(random, projection);
        Matrix4d product = Matrix4d::Identity();
        for (const NormalisingStep& step : normalising_steps(volume, canonical))
          product = step.matrix * product;
        if (projection == Projection::perspective) product *= volume.far_m;  // to w = -z
        EXPECT_TRUE(product.isApprox(clip_from_eye(volume, canonical), 1e-13));
      }
    }
  }
}

TEST(ClipFromEye, AFrustumsSidesAreAt45DegreesAfterTheSecondStep) {
  const auto steps = normalising_steps(kFrustum, CanonicalVolume::phigs);
  const Matrix4d pyramid_from_eye = steps[1].matrix * steps[0].matrix;
  for (const Vector3d& corner : corners(kFrustum)) {
    const Vector3d x = (pyramid_from_eye * corner.homogeneous()).head<3>();
    EXPECT_NEAR(std::abs(x.x()), -x.z(), 1e-15);
    EXPECT_NEAR(std::abs(x.y()), -x.z(), 1e-15);
  }
}

TEST(ClipFromEye, FarMayBeInfinity) {
  ViewVolume volume = kFrustum;
  volume.far_m = kInfinity;
  const Matrix4d endless = clip_from_eye(volume);
  EXPECT_EQ(endless(2, 2), -1);
  EXPECT_EQ(endless(2, 3), -2 * volume.near_m);
  volume.far_m = 1e15;
  EXPECT_TRUE(clip_from_eye(volume).isApprox(endless, 1e-14));
}

TEST(ClipFromEye, RefusesAVolumeThatIsNone) {
  ViewVolume v = kFrustum;
  v.near_m = 0;
  EXPECT_THROW(clip_from_eye(v), Error);
  v.near_m = 3;  // beyond far
  EXPECT_THROW(clip_from_eye(v), Error);
  v = kFrustum;
  v.window.left = v.window.right;
  EXPECT_THROW(clip_from_eye(v), Error);
  v = kFrustum;
  v.window.top = std::nan("");
  EXPECT_THROW(clip_from_eye(v), Error);
  v = kBox;
  v.far_m = kInfinity;
  EXPECT_THROW(clip_from_eye(v), Error);
  v = kBox;
  v.near_m = -4;  // a box may begin behind the eye
  EXPECT_NO_THROW(clip_from_eye(v));
}

TEST(SymmetricFrustum, HasItsFieldOfView) {
  const ViewVolume volume = symmetric_frustum(kPi / 2, 1.5, 2, 10);
  EXPECT_NEAR(volume.window.top, 2, 1e-15);
  EXPECT_NEAR(volume.window.right, 3, 1e-15);
  EXPECT_EQ(volume.window.left, -volume.window.right);
  EXPECT_EQ(volume.window.bottom, -volume.window.top);
  EXPECT_THROW(symmetric_frustum(kPi, 1, 1, 2), Error);
  EXPECT_THROW(symmetric_frustum(0, 1, 1, 2), Error);
}

TEST(Depth, WorkedNumbersForNearThreeTenthsOfFar) {
  const double k = 0.3;
  EXPECT_NEAR(phigs_depth(-0.3, k), 0, 1e-15);
  EXPECT_NEAR(phigs_depth(-1, k), -1, 1e-15);
  EXPECT_NEAR(phigs_depth(-0.65, k), -0.35 / 0.65 / 0.7, 1e-15);  // half way: 0.77 of the depth
  EXPECT_NEAR(z_from_phigs_depth(-0.5, k), -0.3 / 0.65, 1e-15);   // half the depth: 0.46 of far
  for (double z = -1; z <= -0.3; z += 0.01)
    EXPECT_NEAR(z_from_phigs_depth(phigs_depth(z, k), k), z, 1e-15);
}

TEST(Depth, AgreesWithTheMatrices) {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const ViewVolume v = random_volume(random, Projection::perspective);
    const double z = -random.uniform(v.near_m, v.far_m);
    const Eigen::Vector4d x(0, 0, z, 1);
    const auto ph = divided(clip_from_eye(v, CanonicalVolume::phigs) * x);
    const auto gl = divided(clip_from_eye(v, CanonicalVolume::opengl) * x);
    EXPECT_NEAR(ph->z(), phigs_depth(z / v.far_m, v.near_m / v.far_m), 1e-12);
    EXPECT_NEAR(gl->z(), opengl_depth(z, v.near_m, v.far_m), 1e-12);
    EXPECT_NEAR(z_from_opengl_depth(gl->z(), v.near_m, v.far_m), z,
                1e-14 * z * z / v.near_m + 1e-14);
  }
}

TEST(Depth, KeepsOrderAndPlanes) {
  const Matrix4d m = clip_from_eye(kFrustum);
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    // Points of a plane, on a line of sight apart from each other, stay in one plane.
    const Vector3d a(0.1, 0.2, -1), u(random.normal(), random.normal(), 0.3),
        w(random.normal(), random.normal(), -0.2);
    Matrix4d image;
    const double along[4][2] = {{0, 0}, {0.2, 0}, {0, 0.2}, {0.15, -0.1}};
    for (int j = 0; j < 4; ++j) {
      const Vector3d x = a + along[j][0] * u + along[j][1] * w;
      image.col(j) = divided(m * x.homogeneous()).value().homogeneous();
    }
    EXPECT_NEAR(image.determinant(), 0, 1e-12);
  }
  double before = -kInfinity;
  for (double z = -0.6; z >= -2; z -= 0.05) {
    EXPECT_GT(opengl_depth(z, 0.6, 2), before);
    before = opengl_depth(z, 0.6, 2);
  }
}

TEST(Depth, PrecisionIsSpentNearTheEye) {
  // 16 bits between 0.1 m and 100 m: 1.5 um at near, 1.5 m at far, a step of the buffer apart.
  EXPECT_NEAR(depth_resolution_m(-0.1, 0.1, 100, 16), 1.5243e-6, 1e-9);
  EXPECT_NEAR(depth_resolution_m(-100, 0.1, 100, 16), 1.5243, 1e-3);
  const double step = 2.0 / 65535;
  const double z = z_from_opengl_depth(opengl_depth(-10, 0.1, 100) + step, 0.1, 100);
  EXPECT_NEAR(-10 - z, depth_resolution_m(-10, 0.1, 100, 16), 1e-4);
}

Camera random_pinhole(Random& random) {
  const ImageSize size{static_cast<int>(random.uniform(200, 4000)),
                       static_cast<int>(random.uniform(200, 4000))};
  return {pinhole(random.uniform(100, 3000), random.uniform(100, 3000), random.uniform(-500, 3000),
                  random.uniform(-500, 3000)),
          size};
}

TEST(OpenGlMatrix, OfACalibratedCamera) {
  const Camera camera{pinhole(900, 910, 650, 390), {1280, 800}};
  const Matrix4d m = clip_from_eye(view_volume(camera, 0.1, 50));
  const double n = 0.1, f = 50;
  Matrix4d expected;
  expected << 2 * 900.0 / 1280, 0, 1 - 2 * 650.5 / 1280, 0,  //
      0, 2 * 910.0 / 800, 2 * 390.5 / 800 - 1, 0,            //
      0, 0, -(f + n) / (f - n), -2 * f * n / (f - n),        //
      0, 0, -1, 0;
  EXPECT_TRUE(m.isApprox(expected, 1e-14)) << m;
}

TEST(OpenGlMatrix, DrawsWhereTheLensProjects) {
  Random random(4);
  for (int i = 0; i < 10000; ++i) {
    const bool parallel = i % 4 == 0;
    Camera camera = random_pinhole(random);
    if (parallel) camera.lens = Parallel({random.uniform(10, 900), random.uniform(10, 900), 3, 4});
    const Matrix4d m = clip_from_eye(view_volume(camera, 0.1, 50));
    const Vector3d x(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(0.1, 50));
    const Vector3d x_in_eye(x.x(), -x.y(), -x.z());
    const Vector3d ndc = divided(m * x_in_eye.homogeneous()).value();
    const Vector3d pixel = (raster_from_ndc({camera.image_size}) * ndc.homogeneous()).head<3>();
    const Eigen::Vector2d expected = project(camera.lens, x).value();
    EXPECT_LT((pixel.head<2>() - expected).norm(), 1e-9 + 1e-13 * expected.norm());
    EXPECT_LE(std::abs(ndc.z()), 1 + 1e-12);
  }
}

TEST(OpenGlMatrix, GivesTheCameraBack) {
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    Camera camera = random_pinhole(random);
    if (i % 4 == 0)
      camera.lens = Parallel({random.uniform(10, 900), random.uniform(10, 900), 3, 4});
    const double near = random.uniform(0.01, 1), far = random.uniform(2, 100);
    const double scale = random.uniform(0.1, 10);  // homogeneous matrices have no scale
    const Matrix4d m = scale * clip_from_eye(view_volume(camera, near, far));
    const CameraFromMatrix back = camera_from_opengl(m, camera.image_size);
    EXPECT_EQ(back.camera.lens.index(), camera.lens.index());
    for (std::size_t p = 0; p < 4; ++p)
      EXPECT_NEAR(parameters(back.camera.lens)[p], parameters(camera.lens)[p], 1e-10);
    EXPECT_NEAR(back.near_m, near, 1e-12);
    EXPECT_NEAR(back.far_m / far, 1, 1e-9);
  }
  const Camera camera{pinhole(900, 910, 650, 390), {1280, 800}};
  const Matrix4d endless = clip_from_eye(view_volume(camera, 0.1, kInfinity));
  EXPECT_EQ(camera_from_opengl(endless, {1280, 800}).far_m, kInfinity);
}

TEST(OpenGlMatrix, RefusesWhatIsNoCamera) {
  const Matrix4d m = clip_from_eye(kFrustum);
  const auto with = [&](int row, int column, double value) {
    Matrix4d changed = m;
    changed(row, column) = value;
    return changed;
  };
  const ImageSize size{640, 480};
  EXPECT_NO_THROW(camera_from_opengl(m, size));
  EXPECT_THROW(camera_from_opengl(with(0, 1, 0.1), size), Error);  // skew
  EXPECT_THROW(camera_from_opengl(with(0, 0, -1), size), Error);   // mirrored
  EXPECT_THROW(camera_from_opengl(with(3, 2, 1), size), Error);    // looks along +z
  EXPECT_THROW(camera_from_opengl(with(3, 3, 0.5), size), Error);  // neither of the two
  EXPECT_THROW(camera_from_opengl(with(2, 3, 0), size), Error);    // no near plane
  EXPECT_THROW(camera_from_opengl(with(1, 1, std::nan("")), size), Error);
  EXPECT_THROW(camera_from_opengl(Matrix4d::Zero(), size), Error);
  EXPECT_THROW(camera_from_opengl(Matrix4d::Identity(), size), Error);  // depth runs backwards
}

TEST(OpenGlMatrix, RefusesALensThatNoMatrixHolds) {
  const Perspective distorted({900, 900, 640, 400, -0.1, 0, 0, 0, 0, 0, 0, 0});
  const Camera camera{distorted, {1280, 800}};
  EXPECT_THROW(view_volume(camera, 0.1, 10), Error);
  EXPECT_NO_THROW(view_volume(undistorted(camera), 0.1, 10));
  EXPECT_THROW(view_volume({Fisheye({300, 300, 1, 1, 0, 0, 0, 0}), {4, 4}}, 0.1, 10), Error);
}

TEST(Canonical, DepthFromZeroToOneAndReversed) {
  for (const bool perspective : {true, false}) {
    const ViewVolume volume{perspective ? Projection::perspective : Projection::parallel,
                            {-0.2, 0.3, -0.1, 0.2},
                            0.5,
                            8};
    for (const auto& [canonical, near, far] : {std::tuple{CanonicalVolume::zero_to_one, 0.0, 1.0},
                                               {CanonicalVolume::one_to_zero, 1.0, 0.0},
                                               {CanonicalVolume::opengl, -1.0, 1.0},
                                               {CanonicalVolume::phigs, 0.0, -1.0}}) {
      const Eigen::Matrix4d clip = clip_from_eye(volume, canonical);
      const auto depth = [&](double z) {
        return (clip * Eigen::Vector4d(0, 0, z, 1)).hnormalized().z();
      };
      EXPECT_NEAR(depth(-0.5), near, 1e-15);
      EXPECT_NEAR(depth(-8), far, 1e-15);
      Eigen::Matrix4d product = Eigen::Matrix4d::Identity();
      for (const NormalisingStep& step : normalising_steps(volume, canonical))
        product = step.matrix * product;
      EXPECT_LT((product / product.norm() - clip / clip.norm()).norm(), 1e-15);
    }
  }
}

}  // namespace
}  // namespace tagcal
