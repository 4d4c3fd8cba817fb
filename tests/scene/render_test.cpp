#include "tagcal/scene/render.hpp"

#include <gtest/gtest.h>

#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/scene/surfaces.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr ImageSize kSize{640, 400};

// A dark square before a bright background; corners in the camera frame.
Scene square_scene(const Lens& lens, const std::vector<Vector3d>& corners, double blur_px) {
  Scene scene;
  scene.camera = {lens, kSize};
  scene.occluders = {{corners, 0.1}};
  scene.background_level = 0.9;
  scene.sensor.blur_px = blur_px;
  return scene;
}

std::vector<Vector3d> square(const Pose& camera_from_square, double side) {
  std::vector<Vector3d> corners;
  for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
    corners.push_back(camera_from_square * Vector3d(0.5 * side * x, 0.5 * side * y, 0));
  return corners;
}

double darkness(const ImageF& light, int x, int y) {
  return (0.9 - static_cast<double>(light(x, y))) / 0.8;
}

// The image of the segment from a to b, in steps far finer than a pixel.
std::vector<Vector2d> traced(const Lens& lens, const Vector3d& a, const Vector3d& b) {
  std::vector<Vector2d> pixels;
  for (int i = 0; i <= 4000; ++i) pixels.push_back(*project(lens, a + i / 4000.0 * (b - a)));
  return pixels;
}

// How far outwards the edges of the dark square lie from where `project` puts them, on average over
// the rows (of steep edges) or columns (of flat ones) that cross their middle parts. Within such a
// row the amount of darkness is the place of the edge, blurred or not.
struct Bias {
  double sum = 0;
  int count = 0;
  double mean() const { return sum / count; }
};

void measure_edge(const ImageF& light, const std::vector<Vector2d>& edge, const Vector2d& inside,
                  Bias& bias) {
  const Vector2d along = edge[3400] - edge[600];
  const bool steep = std::abs(along.y()) > std::abs(along.x());
  const int main = steep ? 1 : 0, cross = steep ? 0 : 1;
  const Vector2d normal = Vector2d(along.y(), -along.x()).normalized();
  const double outward = normal.dot(inside - edge[2000]) > 0 ? -normal[cross] : normal[cross];
  for (std::size_t i = 600; i < 3400; ++i) {
    // The pixel row whose centre the edge passes here.
    const double from = edge[i][main], to = edge[i + 1][main];
    const double row = std::ceil(std::min(from, to));
    if (!(row < std::max(from, to))) continue;
    const double expected =
        edge[i][cross] + (row - from) / (to - from) * along[cross] / along[main] * (to - from);
    const int low = static_cast<int>(std::floor(expected)) - 8, high = low + 16;
    if (low < 0 || high >= (steep ? kSize.width : kSize.height)) continue;
    if (row < 6 || row >= (steep ? kSize.height : kSize.width) - 6) continue;
    double dark = 0;
    for (int k = low; k <= high; ++k)
      dark += steep ? darkness(light, k, static_cast<int>(row))
                    : darkness(light, static_cast<int>(row), k);
    const bool dark_above = inside[cross] > expected;
    const double measured = dark_above ? high + 0.5 - dark : low - 0.5 + dark;
    bias.sum += outward * (measured - expected);
    ++bias.count;
  }
}

Bias measure(const Lens& lens, const std::vector<Vector3d>& corners, double blur_px) {
  const ImageF light = render_light(square_scene(lens, corners, blur_px), {}, Pose());
  const Vector2d inside =
      *project(lens, 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]));
  Bias bias;
  for (std::size_t i = 0; i < 4; ++i)
    measure_edge(light, traced(lens, corners[i], corners[(i + 1) % 4]), inside, bias);
  return bias;
}

TEST(Render, EdgesLieWhereProjectPutsThem) {
  Random random(1);
  const Lens lenses[] = {pinhole(450, 450, 319.5, 199.5),
                         Perspective({450, 448, 325, 196, -0.15, 0.05, 5e-4, -3e-4}),
                         Fisheye({210, 209, 316, 202, 0.02, -0.01})};
  for (const Lens& lens : lenses) {
    for (const double blur : {0.0, 0.8}) {
      Bias all;
      for (int i = 0; i < 6; ++i) {
        const Pose pose(exp_rotation({random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6),
                                      random.uniform(-3, 3)}),
                        {random.uniform(-0.15, 0.15), random.uniform(-0.1, 0.1), 1});
        const Bias one = measure(lens, square(pose, 0.3), blur);
        EXPECT_LT(std::abs(one.mean()), 0.002) << "blur " << blur;
        all.sum += one.sum;
        all.count += one.count;
      }
      EXPECT_GT(all.count, 800);
      EXPECT_LT(std::abs(all.mean()), 0.0005) << "blur " << blur;
    }
  }
}

TEST(Render, AxisAlignedEdgesLieAtAnyPhase) {
  const Lens lens = pinhole(400, 400, 319.5, 199.5);
  for (int i = 0; i < 8; ++i) {
    const double phase = (0.13 * i) / 400;  // pixels at unit distance
    const Pose pose(Eigen::Quaterniond::Identity(), {phase, 0.7 * phase, 1});
    for (const double blur : {0.0, 0.5, 1.5})
      EXPECT_LT(std::abs(measure(lens, square(pose, 0.2503), blur).mean()), 1e-4)
          << i << " " << blur;
  }
}

TEST(Render, CoveredAreaIsThatOfTheOutline) {
  Random random(2);
  const Lens lens = Perspective({450, 448, 325, 196, -0.15, 0.05});
  for (int i = 0; i < 5; ++i) {
    const Pose pose(exp_rotation({random.uniform(-0.6, 0.6), 0.3, random.uniform(-3, 3)}),
                    {0, 0, 1});
    const auto corners = square(pose, 0.3);
    double area = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto edge = traced(lens, corners[k], corners[(k + 1) % 4]);
      for (std::size_t j = 0; j + 1 < edge.size(); ++j)
        area += 0.5 * (edge[j].x() * edge[j + 1].y() - edge[j].y() * edge[j + 1].x());
    }
    const ImageF light = render_light(square_scene(lens, corners, 0), {}, Pose());
    double sum = 0;
    for (int y = 0; y < kSize.height; ++y)
      for (int x = 0; x < kSize.width; ++x) sum += darkness(light, x, y);
    EXPECT_NEAR(sum / std::abs(area), 1, 1e-5);
  }
}

TEST(Render, WhatCrossesBordersAndTheNearPlaneIsCut) {
  const Lens lens = pinhole(400, 400, 319.5, 199.5);
  // A floor from behind the camera to far ahead: the lower half of the image.
  const std::vector<Vector3d> floor = {{-50, 1, -5}, {50, 1, -5}, {500, 1, 1000}, {-500, 1, 1000}};
  const ImageF light = render_light(square_scene(lens, floor, 0), {}, Pose());
  EXPECT_NEAR(darkness(light, 320, 390), 1, 1e-5);
  EXPECT_NEAR(darkness(light, 320, 210), 1, 1e-5);
  EXPECT_NEAR(darkness(light, 320, 190), 0, 1e-5);
  // All of it behind the camera: nothing.
  const ImageF none = render_light(
      square_scene(lens, square(Pose(Eigen::Quaterniond::Identity(), {0, 0, -1}), 0.5), 0), {},
      Pose());
  EXPECT_NEAR(darkness(none, 320, 200), 0, 1e-6);
}

Scene board_scene(const Board& board) {
  Scene scene;
  scene.camera = {pinhole(900, 900, 319.5, 199.5), kSize};
  scene.boards = {{board, Pose(Eigen::Quaterniond::Identity(), {-0.05, -0.05, 0})}};
  return scene;
}

const Pose kFrontal = camera_from_world_looking_at({0, 0, 0.4}, {0, 0, 0}, {0, 1, 0});

TEST(Render, TagsShowTheirBits) {
  for (const int border : {1, 2}) {
    const Board board = make_board(AprilGrid{1, 1, 0.1, 0.3, 5, "tag36h11", border, border == 2});
    const TagFamily family = tag_family("tag36h11", border);
    const Scene scene = board_scene(board);
    const ImageF light = render_light(scene, {{"tag36h11", family}}, kFrontal);
    const double cell = 0.1 / family.width_at_border;
    for (std::size_t bit = 0; bit < family.bits.size(); ++bit) {
      const Vector3d centre(-0.05 + (family.bits[bit].x + 0.5) * cell,
                            0.05 - (family.bits[bit].y + 0.5) * cell, 0);
      const Vector2d pixel = *project(scene.camera.lens, kFrontal * centre);
      const bool white = (family.codes[5] >> (family.bits.size() - 1 - bit)) & 1;
      EXPECT_NEAR(
          light(static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))),
          white ? scene.paper_level : scene.ink_level, 1e-5)
          << "border " << border << " bit " << bit;
    }
  }
}

// A row through the lower border of a tag is black from side to side, a column through the left one
// from below to above.
TEST(Render, InkSpreadsByAsMuchAsItSays) {
  const TagFamilies families = {{"tag36h11", tag_family("tag36h11", 1)}};
  Scene scene = board_scene(make_board(AprilGrid{1, 1, 0.1, 0.3, 5, "tag36h11", 1, false}));
  const double px_per_m = 900 / 0.4, cell = 0.1 / 8;
  const Vector2d in_border =
      *project(scene.camera.lens, kFrontal * Vector3d(-0.05 + cell / 2, -0.05 + cell / 2, 0));
  const int x0 = static_cast<int>(std::lround(in_border.x()));
  const int y0 = static_cast<int>(std::lround(in_border.y()));
  const int reach = static_cast<int>(0.065 * px_per_m);  // on the paper, which ends at 0.07
  for (const double spread : {0.0, 0.0005, -0.0013}) {
    scene.ink_spread_m = spread;
    const ImageF light = render_light(scene, families, kFrontal);
    double width = 0, height = 0;
    for (int i = -reach; i <= reach; ++i) {
      width += scene.paper_level - static_cast<double>(light(320 + i, y0));
      height += scene.paper_level - static_cast<double>(light(x0, 200 + i));
    }
    const double contrast = scene.paper_level - scene.ink_level;
    EXPECT_NEAR(width / contrast, (0.1 + 2 * spread) * px_per_m, 1e-3) << spread;
    EXPECT_NEAR(height / contrast, (0.1 + 2 * spread) * px_per_m, 1e-3) << spread;
  }
  scene.ink_spread_m = 0.03;  // over the paper's border
  EXPECT_THROW(render_light(scene, families, kFrontal), Error);
}

TEST(Render, ABoardFromBehindIsPaper) {
  const Scene scene = board_scene(make_board(AprilGrid{1, 1, 0.1, 0.3, 5, "tag36h11", 1, false}));
  const Pose behind = camera_from_world_looking_at({0, 0, -0.4}, {0, 0, 0}, {0, 1, 0});
  const ImageF light = render_light(scene, {{"tag36h11", tag_family("tag36h11", 1)}}, behind);
  EXPECT_NEAR(light(320, 200), scene.paper_level, 1e-6);
  EXPECT_NEAR(light(5, 5), scene.background_level, 1e-6);
}

TEST(Render, NearerThingsHideFartherOnes) {
  Scene scene = board_scene(make_board(AprilGrid{1, 1, 0.1, 0.3, 5, "tag36h11", 1, false}));
  scene.occluders = {
      {{{-0.02, -0.02, 0.1}, {0.02, -0.02, 0.1}, {0.02, 0.02, 0.1}, {-0.02, 0.02, 0.1}}, 0.3},
      {{{-1, -1, -0.1}, {1, -1, -0.1}, {1, 1, -0.1}, {-1, 1, -0.1}}, 0.7}};
  const ImageF light = render_light(scene, {{"tag36h11", tag_family("tag36h11", 1)}}, kFrontal);
  EXPECT_NEAR(light(320, 200), 0.3, 1e-6);
  EXPECT_NEAR(light(5, 200), 0.7, 1e-6);
}

TEST(Render, UnknownFamilyOrTagIsAnError) {
  const Scene scene = board_scene(make_board(AprilGrid{1, 1, 0.1, 0.3, 5, "tag36h11", 1, false}));
  EXPECT_THROW(render_light(scene, {}, kFrontal), Error);
  const Scene far = board_scene(make_board(AprilGrid{1, 1, 0.1, 0.3, 5000, "tag36h11", 1, false}));
  EXPECT_THROW(render_light(far, {{"tag36h11", tag_family("tag36h11", 1)}}, kFrontal), Error);
}

TEST(Expose, GammaIsThePowerOfTheLight) {
  ImageF light({5, 1});
  const float levels[] = {0, 0.04f, 0.25f, 1, 1.5f};
  std::copy_n(levels, 5, light.row(0));
  Sensor sensor;
  sensor.gamma = 0.5;
  EXPECT_EQ(expose(light, sensor, 1).pixels(), (std::vector<std::uint8_t>{0, 51, 128, 255, 255}));
  sensor.gamma = 2;
  EXPECT_EQ(expose(light, sensor, 1).pixels(), (std::vector<std::uint8_t>{0, 0, 16, 255, 255}));
  // Noise is of the levels, as a picture shows them.
  sensor.gamma = 0.45;
  sensor.noise_levels = 3;
  double squares = 0;
  const Image16 flat = expose16(ImageF({640, 400}, 0.1f), sensor, 7);
  const double level = 255 * std::pow(static_cast<double>(0.1f), 0.45);
  for (const std::uint16_t value : flat.pixels())
    squares += (value / 257.0 - level) * (value / 257.0 - level);
  EXPECT_NEAR(squares / static_cast<double>(flat.pixels().size()), 9, 0.1);
}

TEST(Expose, EqualSeedsGiveEqualBytesAndNoiseIsAsStated) {
  const ImageF light(kSize, 0.5f);
  Sensor sensor;
  sensor.noise_levels = 3;
  const Image8 a = expose(light, sensor, 7), b = expose(light, sensor, 7),
               c = expose(light, sensor, 8);
  EXPECT_EQ(a.pixels(), b.pixels());
  EXPECT_NE(a.pixels(), c.pixels());
  double sum = 0, squares = 0;
  for (const std::uint8_t level : a.pixels()) {
    sum += level - 127.5;
    squares += (level - 127.5) * (level - 127.5);
  }
  const double n = static_cast<double>(a.pixels().size());
  EXPECT_NEAR(sum / n, 0, 0.03);
  EXPECT_NEAR(squares / n, 9 + 1.0 / 12, 0.1);
}

}  // namespace
}  // namespace tagcal
