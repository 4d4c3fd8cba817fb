#include "tagcal/reproject/resampling.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "poses.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/reproject/cameras.hpp"
#include "tagcal/reproject/maps.hpp"
#include "tagcal/scene/render.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr ImageSize kResampledSize = {640, 400};
const Perspective kBarrelLens({450, 450, 330, 190, -0.25, 0.08, 1e-3, -1e-3, 0, 0, 0, 0});

template <typename T>
Image<T> noise(const ImageSize& size) {
  Image<T> image(size);
  Random random(7, 0);
  for (int y = 0; y < size.height; ++y) {
    auto* const bytes = reinterpret_cast<unsigned char*>(image.row(y));
    for (std::size_t i = 0; i < sizeof(T) * static_cast<std::size_t>(size.width); ++i)
      bytes[i] = static_cast<unsigned char>(random.next());
  }
  return image;
}

// A picture of a function of the pixel.
template <typename T = std::uint8_t, typename F>
Image<T> drawn(const ImageSize& size, const F& f) {
  Image<T> image(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) image(x, y) = static_cast<T>(std::lround(f(x, y)));
  return image;
}

// The map x -> scale x + offset of a picture of `size`.
PixelMap linear_map(const ImageSize& size, const Eigen::Matrix2d& scale, const Vector2d& offset) {
  PixelMap map{ImageF(size), ImageF(size)};
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const Vector2d at = scale * Vector2d(x, y) + offset;
      map.x(x, y) = static_cast<float>(at.x());
      map.y(x, y) = static_cast<float>(at.y());
    }
  }
  return map;
}

constexpr Interpolation kAll[] = {Interpolation::nearest, Interpolation::bilinear,
                                  Interpolation::lanczos4};

template <typename T>
void expect_identity() {
  const Image<T> picture = noise<T>(kResampledSize);
  for (const Lens& lens : {Lens(kBarrelLens), Lens(Fisheye({300, 310, 320, 200, 0.02, 0, 0, 0}))}) {
    for (const Interpolation interpolation : kAll) {
      const Camera camera{lens, kResampledSize};
      const auto same = reproject(picture, {camera, camera, {}}, {interpolation});
      EXPECT_EQ(same.image.pixels(), picture.pixels()) << static_cast<int>(interpolation);
      EXPECT_EQ(same.seen.pixels(), Image8(kResampledSize, 255).pixels());
    }
  }
}

TEST(Resampling, ACameraIntoItselfLeavesTheBytes) {
  expect_identity<std::uint8_t>();
  expect_identity<std::uint16_t>();
  expect_identity<Rgb>();
  expect_identity<Rgb16>();
}

// The formula of bilinear interpolation in double, clamped at the border.
template <typename V>
double bilinear(const V& value, const ImageSize& size, double x, double y) {
  const int u = static_cast<int>(std::floor(x)), v = static_cast<int>(std::floor(y));
  const auto at = [&](int i, int j) {
    return value(std::clamp(i, 0, size.width - 1), std::clamp(j, 0, size.height - 1));
  };
  const double fx = x - u, fy = y - v;
  return (1 - fy) * ((1 - fx) * at(u, v) + fx * at(u + 1, v)) +
         fy * ((1 - fx) * at(u, v + 1) + fx * at(u + 1, v + 1));
}

template <typename T, typename Channel>
void expect_bilinear(const Channel& channel, const T& border) {
  const ImageSize size{203, 151};
  const Image<T> picture = noise<T>(size);
  const Eigen::Matrix2d turn = 0.9 * Eigen::Rotation2Dd(0.3).toRotationMatrix();
  const PixelMap map = linear_map({221, 173}, turn, {8.3, -20.7});
  const Resampled<T> result = remap(picture, map, {}, border);
  int seen = 0;
  for (int y = 0; y < 173; ++y) {
    for (int x = 0; x < 221; ++x) {
      const double u = map.x(x, y), v = map.y(x, y);
      const bool inside = contains(size, {u, v});
      ASSERT_EQ(result.seen(x, y), inside ? 255 : 0);
      if (!inside) {
        ASSERT_EQ(result.image(x, y), border);
        continue;
      }
      ++seen;
      const double expected =
          bilinear([&](int i, int j) { return channel(picture(i, j)); }, size, u, v);
      ASSERT_NEAR(channel(result.image(x, y)), expected, 0.52) << x << " " << y;
    }
  }
  EXPECT_GT(seen, 15000);
}

TEST(Resampling, BilinearIsItsFormulaInAllKinds) {
  expect_bilinear<std::uint8_t>([](std::uint8_t v) { return double(v); }, 17);
  expect_bilinear<std::uint16_t>([](std::uint16_t v) { return double(v); }, 1700);
  for (std::size_t k = 0; k < 3; ++k) {
    expect_bilinear<Rgb>([k](const Rgb& v) { return double(v[k]); }, Rgb{1, 2, 3});
    expect_bilinear<Rgb16>([k](const Rgb16& v) { return double(v[k]); }, Rgb16{1, 2, 3000});
  }
}

TEST(Resampling, AgreesWithOpenCvsRemap) {
  const Image8 picture = drawn(kResampledSize, [](int x, int y) {
    return 128 + 60 * std::sin(0.11 * x + 0.05 * y) + 50 * std::cos(0.07 * y);
  });
  const Camera camera{kBarrelLens, kResampledSize};
  const Camera target{pinhole(450, 450, 330, 190), kResampledSize};
  const PixelMap map = pixel_map({camera, target, {}});
  const auto mat = [](const auto& image, int type) {
    return cv::Mat(image.height(), image.width(), type,
                   const_cast<void*>(static_cast<const void*>(image.row(0))));
  };
  for (const auto& [interpolation, flag] :
       {std::pair(Interpolation::nearest, cv::INTER_NEAREST),
        std::pair(Interpolation::bilinear, cv::INTER_LINEAR),
        std::pair(Interpolation::lanczos4, cv::INTER_LANCZOS4)}) {
    cv::Mat theirs;
    cv::remap(mat(picture, CV_8UC1), theirs, mat(map.x, CV_32FC1), mat(map.y, CV_32FC1), flag,
              cv::BORDER_REPLICATE);
    const auto ours = reproject(picture, {camera, target, {}}, {interpolation, false});
    int different = 0, seen = 0;
    for (int y = 0; y < kResampledSize.height; ++y) {
      for (int x = 0; x < kResampledSize.width; ++x) {
        if (ours.seen(x, y) == 0) continue;
        ++seen;  // OpenCV's coordinates are rounded to 1/32 px
        different += std::abs(ours.image(x, y) - theirs.at<std::uint8_t>(y, x)) > 1;
      }
    }
    EXPECT_LE(different, seen / 1000) << flag;
  }
}

TEST(Resampling, LanczosReproducesWhatIsBandLimited) {
  const auto wave = [](double x, double y) {  // up to 0.3 cycles per pixel
    return 30000 + 12000 * std::sin(1.8 * x + 0.3) + 11000 * std::cos(1.2 * y + 0.4 * x);
  };
  const Image16 picture = drawn<std::uint16_t>({300, 200}, wave);
  const Eigen::Matrix2d turn = 0.8 * Eigen::Rotation2Dd(0.2).toRotationMatrix();
  const PixelMap map = linear_map({200, 100}, turn, {60, 40});
  double lanczos = 0, linear = 0;
  const auto fine = remap(picture, map, {Interpolation::lanczos4});
  const auto coarse = remap(picture, map, {Interpolation::bilinear});
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 200; ++x) {
      const double expected = wave(map.x(x, y), map.y(x, y));
      lanczos = std::max(lanczos, std::abs(fine.image(x, y) - expected));
      linear = std::max(linear, std::abs(coarse.image(x, y) - expected));
    }
  }
  EXPECT_LT(lanczos, 23000 * 0.03);
  EXPECT_GT(linear, 23000 * 0.25);
}

// The share of a wave that is left after shrinking, as a standard deviation.
double left_over(Interpolation interpolation, const Eigen::Matrix2d& scale, double frequency,
                 bool area_correct, double* mean) {
  const Image8 picture = drawn({1200, 1200}, [&](int x, int y) {
    return 127 + 100 * std::sin(2 * kPi * frequency * (x + 0.37 * y));
  });
  const PixelMap map = linear_map({100, 100}, scale, {100.3, 400.2});
  const auto small = remap(picture, map, {interpolation, area_correct});
  double sum = 0, squares = 0;
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 100; ++x) {
      EXPECT_EQ(small.seen(x, y), 255);
      sum += small.image(x, y) / 1e4;
      squares += std::pow(small.image(x, y), 2) / 1e4;
    }
  }
  *mean = sum;
  return std::sqrt(std::max(0.0, squares - sum * sum)) / (100 / std::sqrt(2));
}

// A wave too fine for the target becomes its mean, not a coarse wave; also where the target shrinks
// along one direction only, across the rows of the source.
TEST(Resampling, ShrinkingDoesNotAlias) {
  const Eigen::Matrix2d even = 5 * Eigen::Matrix2d::Identity();
  Eigen::Matrix2d slanted = Eigen::Vector2d(7, 1).asDiagonal();
  slanted = Eigen::Rotation2Dd(0.36).toRotationMatrix() * slanted;
  for (const Eigen::Matrix2d& scale : {even, slanted}) {
    for (const Interpolation interpolation : {Interpolation::bilinear, Interpolation::lanczos4}) {
      double mean = 0;
      EXPECT_GT(left_over(interpolation, scale, 0.21, false, &mean), 0.5);
      EXPECT_LT(left_over(interpolation, scale, 0.21, true, &mean), 0.06);
      EXPECT_NEAR(mean, 127, 0.7);
      // What the target can show is kept.
      EXPECT_GT(left_over(interpolation, scale, 0.01, true, &mean), 0.9);
    }
  }
}

// Detail along the other direction of a slanted footprint survives.
TEST(Resampling, ASlantedFootprintKeepsTheOtherDirection) {
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(0.36).toRotationMatrix();
  const Eigen::Matrix2d scale = turn * Eigen::Matrix2d(Eigen::Vector2d(7, 1).asDiagonal());
  const Vector2d across = turn.col(1);
  const Image8 picture = drawn({1200, 1200}, [&](int x, int y) {
    return 127 + 100 * std::sin(2 * kPi * 0.1 * across.dot(Vector2d(x, y)));
  });
  const auto small = remap(picture, linear_map({100, 100}, scale, {200.3, 300.2}));
  int most = 0, least = 255;
  for (int y = 0; y < 100; ++y) {
    most = std::max<int>(most, small.image(50, y));
    least = std::min<int>(least, small.image(50, y));
  }
  EXPECT_GT(most - least, 170);
}

// The width of the kernel grows without a step: a picture whose scale grows slowly has none either.
TEST(Resampling, ShrinkingSetsInSmoothly) {
  const Image8 picture = drawn({3000, 40}, [](int x, int) { return x % 2 == 0 ? 0 : 255; });
  PixelMap map{ImageF({1500, 32}), ImageF({1500, 32})};
  double u = 10;
  for (int x = 0; x < 1500; ++x) {
    for (int y = 0; y < 32; ++y) {
      map.x(x, y) = static_cast<float>(u);
      map.y(x, y) = static_cast<float>(y);
    }
    u += 1.0 + x / 1500.0;
  }
  const auto small = remap(picture, map);
  const auto contrast = [&](int begin) {
    int most = 0, least = 255;
    for (int x = begin; x < begin + 40; ++x) {
      most = std::max<int>(most, small.image(x, 16));
      least = std::min<int>(least, small.image(x, 16));
    }
    return most - least;
  };
  for (int begin = 0; begin + 80 < 1400; begin += 20)
    EXPECT_LT(std::abs(contrast(begin + 20) - contrast(begin)), 90) << begin;
  EXPECT_LT(contrast(1350), 40);
}

TEST(Resampling, ThreadsAndPartsGiveTheSameBytes) {
  const ImageRgb picture = noise<Rgb>(kResampledSize);
  const Camera camera{kBarrelLens, kResampledSize};
  const Target target = pinhole_of_all_pixels(camera, {333, 222});
  for (const Interpolation interpolation : kAll) {
    const auto one = reproject(picture, {camera, target, {}}, {interpolation, true, 1});
    const auto three = reproject(picture, {camera, target, {}}, {interpolation, true, 3});
    EXPECT_EQ(one.image.pixels(), three.image.pixels());
    EXPECT_EQ(one.seen.pixels(), three.seen.pixels());
  }
}

TEST(Resampling, ReadsPicturesOfOthersAndSmallOnes) {
  const Image8 whole = noise<std::uint8_t>({64, 48});
  const ImageView<std::uint8_t> part(whole.row(5) + 7, {20, 10}, 64);
  const PixelMap same = linear_map({20, 10}, Eigen::Matrix2d::Identity(), {0, 0});
  const auto copy = remap(part, same);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 20; ++x) ASSERT_EQ(copy.image(x, y), whole(7 + x, 5 + y));
  for (const ImageSize& size : {ImageSize{1, 1}, {2, 1}, {1, 2}, {3, 3}}) {
    for (const Interpolation interpolation : kAll) {
      const ImageRgb16 picture = noise<Rgb16>(size);
      const auto again =
          remap(picture, linear_map(size, Eigen::Matrix2d::Identity(), {0, 0}), {interpolation});
      EXPECT_EQ(again.image.pixels(), picture.pixels());
    }
  }
}

TEST(Resampling, RefusesPicturesOfAnotherSize) {
  const Camera camera{kBarrelLens, kResampledSize};
  EXPECT_THROW(reproject(Image8({639, 400}), {camera, camera, {}}), Error);
  EXPECT_THROW(reproject(Image8(), {camera, camera, {}}), Error);
  EXPECT_THROW(remap(Image8(kResampledSize), PixelMap{ImageF({3, 3}), ImageF({3, 4})}), Error);
  EXPECT_THROW(remap(Image8(kResampledSize), PixelMap{}), Error);
}

// A board before a camera with distortion, undistorted, is the board before the pinhole.
class RenderedBoard : public testing::Test {
 protected:
  Image8 render(const Camera& camera, const Pose& camera_from_board) const {
    Scene scene;
    scene.camera = camera;
    scene.boards = {{make_board(AprilGrid{4, 3, 0.06, 0.3}), Pose()}};
    const TagFamilies families = {{"tag36h11", tag_family("tag36h11", 2)}};
    return expose(render_light(scene, families, camera_from_board), scene.sensor, 1);
  }

  const Pose pose_ = camera_from_world_looking_at(Vector3d(0.2, -0.05, 0.42),
                                                  Vector3d(0.15, 0.11, 0), Vector3d(0.1, 1, 0));
};

TEST_F(RenderedBoard, UndistortedEqualsThatOfThePinhole) {
  const Camera camera{kBarrelLens, kResampledSize};
  const Camera target = pinhole_of_valid_pixels(camera, kResampledSize);
  const Image8 expected = render(target, pose_);
  const auto ours =
      reproject(render(camera, pose_), {camera, target, {}}, {Interpolation::lanczos4});
  double squares = 0;
  for (int y = 0; y < kResampledSize.height; ++y)
    for (int x = 0; x < kResampledSize.width; ++x) {
      ASSERT_EQ(ours.seen(x, y), 255);
      squares += std::pow(ours.image(x, y) - expected(x, y), 2);
    }
  EXPECT_LT(std::sqrt(squares / (kResampledSize.width * kResampledSize.height)),
            6);  // of 255; edges are resampled
}

TEST_F(RenderedBoard, OnItsPlaneHasTagsOfTheRightSize) {
  const Camera camera{kBarrelLens, {1280, 800}};
  Camera twice = camera;
  twice.lens = Perspective({900, 900, 640, 400, -0.25, 0.08, 1e-3, -1e-3, 0, 0, 0, 0});
  const Image8 picture = render(twice, pose_);
  // 0.5 mm per px about tag 0, whose lower left corner is the origin of the board.
  const PlaneRaster plane{{-0.01, 0.1}, 0.0005, {200, 240}};
  const auto top = reproject(picture, {twice, plane, pose_});
  // Along a row through the tag's middle: white, then the black border from x = 0 to x = 0.06.
  const auto column_of = [&](double x) { return (x + 0.01) / 0.0005; };
  const int v = static_cast<int>(std::lround((0.1 - 0.06 / 16) / 0.0005));  // in the lowest cells
  const auto crossing = [&](int from, int to) {  // place where the grey passes the middle
    const double middle = (top.image(from, v) + top.image(to, v)) / 2.0;
    const int step = from < to ? 1 : -1;
    for (int u = from; u != to; u += step) {
      const double a = top.image(u, v), b = top.image(u + step, v);
      if ((a - middle) * (b - middle) <= 0 && a != b) return u + step * (middle - a) / (b - a);
    }
    return -1.0;
  };
  const int inside = static_cast<int>(column_of(0.03));
  const double left = crossing(inside, static_cast<int>(column_of(-0.005)));
  const double right = crossing(inside, static_cast<int>(column_of(0.065)));
  EXPECT_NEAR(left, column_of(0), 0.4);
  EXPECT_NEAR(right, column_of(0.06), 0.4);
}

}  // namespace
}  // namespace tagcal
