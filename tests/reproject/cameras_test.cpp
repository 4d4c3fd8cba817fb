#include "tagcal/reproject/cameras.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "expect.hpp"
#include "lenses.hpp"
#include "poses.hpp"
#include "tagcal/reproject/maps.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;

constexpr ImageSize kSize = {640, 400};
const Camera kBarrel{Perspective({450, 455, 330, 190, -0.25, 0.08, 1e-3, -1e-3, 0.0, 0, 0, 0}),
                     kSize};
const Camera kPincushion{Perspective({450, 450, 310, 205, 0.2, 0.02, 1e-3, -1e-3, 0, 0, 0, 0}),
                         kSize};

// The new pixel of a pixel of the old picture.
Vector2d undistorted(const Camera& from, const Camera& to, const Vector2d& pixel) {
  return *project(to.lens, ray_in_camera(from.lens, pixel)->direction);
}

// How far a pixel is inside the picture's border; negative outside.
double margin(const ImageSize& size, const Vector2d& p) {
  return std::min({p.x() + 0.5, p.y() + 0.5, size.width - 0.5 - p.x(), size.height - 0.5 - p.y()});
}

std::vector<Vector2d> border(const ImageSize& size) {
  std::vector<Vector2d> pixels;
  for (double s = 0; s <= 1; s += 1.0 / 500) {
    const double u = -0.5 + s * size.width, v = -0.5 + s * size.height;
    for (const Vector2d& p : {Vector2d(u, -0.5), Vector2d(u, size.height - 0.5), Vector2d(-0.5, v),
                              Vector2d(size.width - 0.5, v)})
      pixels.push_back(p);
  }
  return pixels;
}

TEST(NewPinholes, OfAllPixelsContainTheOldBorderAndTouchIt) {
  for (const Camera& camera : {kBarrel, kPincushion}) {
    for (const ImageSize& size : {kSize, ImageSize{500, 500}}) {
      const Camera all = pinhole_of_all_pixels(camera, size);
      double least = 1e9;
      for (const Vector2d& p : border(kSize))
        least = std::min(least, margin(size, undistorted(camera, all, p)));
      EXPECT_NEAR(least, 0, 1e-3);
      EXPECT_NEAR(parameters(all.lens)[1] / parameters(all.lens)[0],
                  parameters(camera.lens)[1] / parameters(camera.lens)[0], 1e-12);
    }
  }
}

TEST(NewPinholes, OfValidPixelsSeeNothingElseAndNoneIsLarger) {
  for (const Camera& camera : {kBarrel, kPincushion}) {
    const Camera valid = pinhole_of_valid_pixels(camera, kSize);
    const Reprojection r{camera, valid, {}};
    double least = 1e9;
    for (const Vector2d& p : border(kSize))
      least = std::min(least, margin(kSize, *source_pixel(r, p)));
    EXPECT_NEAR(least, 0, 1e-3);
    EXPECT_GE(least, -1e-6);
    // One that is 0.2 % wider sees something else wherever it is.
    auto p = std::get<Perspective>(valid.lens).parameters();
    for (double du = -20; du <= 20; du += 1) {
      for (double dv = -20; dv <= 20; dv += 1) {
        const Camera wider{pinhole(p[0] * 0.998, p[1] * 0.998, p[2] + du, p[3] + dv), kSize};
        double outside = 1e9;
        for (const Vector2d& q : border(kSize))
          outside = std::min(outside, margin(kSize, *source_pixel({camera, wider, {}}, q)));
        ASSERT_LT(outside, 0) << du << " " << dv;
      }
    }
  }
}

TEST(NewPinholes, OfAPinholeAreItself) {
  const Camera camera{pinhole(500, 505, 300, 210), kSize};
  for (const Camera& same :
       {pinhole_of_all_pixels(camera, kSize), pinhole_of_valid_pixels(camera, kSize),
        pinhole_of_focal_length(camera, 500, kSize)})
    for (int i = 0; i < 4; ++i)
      EXPECT_NEAR(parameters(same.lens)[i], parameters(camera.lens)[i], 1e-5);
}

// Of another size, the principal point stays at the same place of the picture.
TEST(NewPinholes, OfAFocalLengthHaveTheCentreOfTheResizedPicture) {
  const Camera camera{pinhole(500, 505, 300, 210), kSize};
  for (const ImageSize& size : {ImageSize{2 * kSize.width, 3 * kSize.height},
                                ImageSize{kSize.width / 4, kSize.height / 5}}) {
    const Camera expected = resized(camera, size);
    const Camera given = pinhole_of_focal_length(camera, 700, size);
    EXPECT_NEAR(parameters(given.lens)[2], parameters(expected.lens)[2], 1e-9);
    EXPECT_NEAR(parameters(given.lens)[3], parameters(expected.lens)[3], 1e-9);
  }
}

TEST(NewPinholes, OfAWideFisheyeAreRefusedWithAnAdvice) {
  const Camera wide{Fisheye({180, 180, 320, 200, 0, 0, 0, 0}), kSize};
  EXPECT_HAS(error_of([&] { pinhole_of_all_pixels(wide, kSize); }), "panorama");
  const Camera given = pinhole_of_focal_length(wide, 200, kSize);
  EXPECT_EQ(parameters(given.lens)[0], 200);
  EXPECT_THROW(pinhole_of_focal_length(wide, 0, kSize), Error);
  EXPECT_THROW(pinhole_of_all_pixels(kBarrel, {0, 3}), Error);
}

TEST(SeveralPinholes, SeeEveryRayOfAFisheye) {
  const Camera wide{Fisheye({150, 150, 318.2, 201.7, 0, 0, 0, 0}), kSize};
  const auto count_unseen = [&](int count) {
    const auto cameras = several_pinholes(wide, count);
    EXPECT_EQ(static_cast<int>(cameras.size()), count);
    int unseen = 0;
    for (int v = 0; v < kSize.height; v += 10) {
      for (int u = 0; u < kSize.width; u += 10) {
        const auto ray = ray_in_camera(wide.lens, Vector2d(u, v));
        bool seen = false;
        for (const TurnedCamera& turned : cameras) {
          const auto pixel =
              project(turned.camera.lens, turned.camera_from_turned.inverse() * ray->direction);
          seen = seen || (pixel && contains(turned.camera.image_size, *pixel));
        }
        unseen += !seen;
      }
    }
    return unseen;
  };
  EXPECT_EQ(count_unseen(6), 0);
  EXPECT_GT(count_unseen(5), 0);  // what is behind
  EXPECT_THROW(several_pinholes(wide, 1), Error);
  EXPECT_THROW(several_pinholes(wide, 2), Error);
}

// A fan of pinholes about the vertical axis leaves no gap.
TEST(SeveralPinholes, OfAFanSeeEveryRayAboutTheHorizon) {
  const Camera wide{Fisheye({150, 150, 300, 190, 0, 0, 0, 0}), kSize};
  for (const int count : {3, 4, 7}) {
    const auto cameras = several_pinholes(wide, count);
    ASSERT_EQ(static_cast<int>(cameras.size()), count);
    for (int u = 0; u < kSize.width; u += 3) {
      const auto ray = ray_in_camera(wide.lens, Vector2d(u, 190));
      const bool seen = std::ranges::any_of(cameras, [&](const TurnedCamera& turned) {
        const auto pixel =
            project(turned.camera.lens, turned.camera_from_turned.inverse() * ray->direction);
        return pixel && contains(turned.camera.image_size, *pixel);
      });
      EXPECT_TRUE(seen) << u << " by " << count;
    }
  }
}

TEST(Panoramas, ShowAllOfTheView) {
  const Camera wide{Fisheye({180, 180, 320, 200, 0, 0, 0, 0}), kSize};
  const AngularRange range = angular_range(wide);
  EXPECT_NEAR(range.from_axis_rad, std::hypot(320.5, 200.5) / 180, 1e-9);
  const Panorama panorama = panorama_of(wide, PanoramaKind::equirectangular);
  EXPECT_EQ(panorama.px_per_rad, 180);
  for (int u = 0; u < kSize.width; u += 13) {
    for (int v = 0; v < kSize.height; v += 13) {
      const Eigen::Vector3d d = ray_in_camera(wide.lens, Vector2d(u, v))->direction;
      const Vector2d angles(std::atan2(d.x(), d.z()), std::asin(d.y()));
      EXPECT_TRUE(contains(panorama.size, panorama.centre + 180 * angles)) << u << " " << v;
    }
  }
  // An axis that is not in the middle.
  const Camera aside{Fisheye({180, 180, 420, 140, 0, 0, 0, 0}), kSize};
  for (const PanoramaKind kind : {PanoramaKind::equirectangular, PanoramaKind::cylindrical}) {
    const Panorama all = panorama_of(aside, kind);
    double left = 1e9, right = -1e9;
    for (const Vector2d& p : border(kSize)) {
      const Eigen::Vector3d d = ray_in_camera(aside.lens, p)->direction;
      const double x = all.centre.x() + 180 * std::atan2(d.x(), d.z());
      left = std::min(left, x);
      right = std::max(right, x);
    }
    EXPECT_NEAR(left, 0, 1.5);
    EXPECT_NEAR(right, all.size.width - 1, 1.5);
  }
  const Panorama drum = panorama_of(wide, PanoramaKind::cylindrical, 100);
  EXPECT_LE(drum.size.height, std::ceil(2 * 100 * std::tan(kPi / 3)));
}

}  // namespace
}  // namespace tagcal
