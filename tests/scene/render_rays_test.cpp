// The renderer and the exact corners against rays.
#include <gtest/gtest.h>

#include "random_sheets.hpp"
#include "tagcal/detect/families.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr ImageSize kRayedSize{640, 400};

std::vector<Vector3d> square_in_world(const Pose& world_from_square, double side) {
  std::vector<Vector3d> corners;
  for (const Vector3d& x : tag_corners({0, side, world_from_square})) corners.push_back(x);
  return corners;
}

// A room around a wide fisheye: what is behind the camera shows only where the lens looks back, and
// each pixel shows what its ray meets first.
TEST(RenderRays, AWideFisheyeLooksBehindItself) {
  const double fold = 2.2;  // radians, 126 degrees
  const Lens lenses[] = {Fisheye({130, 130, 319.5, 199.5, 0, 0, 0, 0}),
                         Fisheye({170, 170, 319.5, 199.5, -1 / (3 * fold * fold), 0, 0, 0})};
  const Pose pose(exp_rotation({0.2, -0.3, 0.4}), {0.1, -0.2, 0.3});
  for (const Lens& lens : lenses) {
    Scene scene;
    scene.camera = {lens, kRayedSize};
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {-2.0, 2.0}) {  // six walls, and a board across the room
        const Vector3d n = sign * Vector3d::Unit(axis), u = 2 * Vector3d::Unit((axis + 1) % 3),
                       v = 2 * Vector3d::Unit((axis + 2) % 3);
        scene.occluders.push_back({{n - u - v, n + u - v, n + u + v, n - u + v},
                                   0.1 + 0.1 * static_cast<double>(scene.occluders.size())});
      }
    scene.occluders.push_back(
        {{{-1.5, -1, 0.7}, {1.5, -1, 0.7}, {1.5, -1, -1.7}, {-1.5, -1, -1.7}}, 0.95});
    scene.background_level = 0;
    const ImageF light = render_light(scene, {}, pose);
    const sheet_rays::RayCaster rays(scene, pose);
    const auto level_at = [&](double u, double v) {
      const auto ray = rays.ray({u, v});
      if (!ray) return 0.0;
      const sheet_rays::Surface* hit = rays.first(*ray);
      return hit != nullptr ? hit->level : -1.0;
    };
    int compared = 0;
    for (int y = 0; y < kRayedSize.height; y += 3)
      for (int x = 0; x < kRayedSize.width; x += 3) {
        const double level = level_at(x, y);
        const auto near_it = {level_at(x - 1, y - 1), level_at(x + 1, y - 1),
                              level_at(x - 1, y + 1), level_at(x + 1, y + 1)};
        if (std::ranges::any_of(near_it, [&](double l) { return l != level; })) continue;
        ASSERT_NEAR(light(x, y), level, 1e-3) << x << " " << y;
        ++compared;
      }
    EXPECT_GT(compared, 20000);
  }
}

// The parts of a sheet that another one divides have no seams, whatever the lens bends.
TEST(RenderRays, AHiddenMiddleLeavesNoSeams) {
  const Lens lenses[] = {Perspective({450, 448, 325, 196, -0.15, 0.05, 5e-4, -3e-4}),
                         Fisheye({210, 209, 316, 202, 0.02, -0.01})};
  for (const Lens& lens : lenses) {
    const Pose tilted(exp_rotation({0.5, -0.3, 0.2}), {0.05, 0.02, 1});
    Scene scene;
    scene.camera = {lens, kRayedSize};
    scene.background_level = 0.9;
    scene.occluders = {{square_in_world(tilted, 3), 0.1}};
    const ImageF alone = render_light(scene, {}, Pose());
    const Pose before(exp_rotation({-0.2, 0.3, 0.5}), {0.01, 0.03, 0.7});
    scene.occluders.push_back({square_in_world(before, 0.1), 0.7});
    scene.occluders.push_back({square_in_world(before, 0.4), 0.3});
    const ImageF light = render_light(scene, {}, Pose());
    const sheet_rays::RayCaster rays(scene, Pose());
    sheet_rays::BorderPixels borders(rays, kRayedSize);
    bool cut = false;
    for (const auto& border : sheet_rays::borders(rays.surfaces(), &cut)) borders.add(border);
    int compared = 0;
    for (int y = 0; y < kRayedSize.height; ++y)
      for (int x = 0; x < kRayedSize.width; ++x) {
        if (borders.near(x, y) || rays.first(*rays.ray({x, y})) != &rays.surfaces()[0]) continue;
        ASSERT_EQ(light(x, y), alone(x, y)) << x << " " << y;
        ++compared;
      }
    EXPECT_GT(compared, 60000);
  }
}

// Where sheets cut each other, a pixel has the mean level of its area.
TEST(RenderRays, AreasAtAnIntersectionAreExact) {
  Scene scene;
  scene.camera = {Perspective({450, 448, 325, 196, -0.15, 0.05, 5e-4, -3e-4}), kRayedSize};
  const Pose middle(Eigen::Quaterniond::Identity(), {0.02, 0.01, 1});
  scene.occluders = {
      {square_in_world(middle * Pose(exp_rotation({0.2, 0.6, 0.3}), {0, 0, 0}), 0.4), 0.1},
      {square_in_world(middle * Pose(exp_rotation({-0.5, -0.4, 0}), {0, 0, 0}), 0.5), 0.9}};
  const ImageF light = render_light(scene, {}, Pose());
  const sheet_rays::RayCaster rays(scene, Pose());
  const auto line = sheet_rays::common_line(rays.surfaces()[0], rays.surfaces()[1]).value();
  double worst = 0;
  for (int i = 1; i < 100; ++i) {
    const Vector2d at = *rays.pixel(line.from + i / 100.0 * (line.to - line.from));
    const int x = static_cast<int>(std::lround(at.x())), y = static_cast<int>(std::lround(at.y()));
    double sum = 0;
    for (int k = 0; k < 64 * 64; ++k) {
      const auto* hit = rays.first(*rays.ray({x + (k % 64 - 31.5) / 64, y + (k / 64 - 31.5) / 64}));
      sum += hit != nullptr ? hit->level : scene.background_level;
    }
    worst = std::max(worst, std::abs(sum / (64 * 64) - static_cast<double>(light(x, y))));
  }
  EXPECT_LT(worst, 0.01);  // of the rays: an edge along a row of them is off by half a row of 64
}

// tagcal-study visibility takes 10,000 scenes.
TEST(RenderRays, RandomSheetsAreSeenAsRaysMeetThem) {
  const TagFamilies families = {{"tag36h11", tag_family("tag36h11", 1)}};
  sheet_rays::Counts counts;
  for (std::uint64_t i = 0; i < 100; ++i) {
    const long before = counts.wrong_pixels + counts.wrong_points;
    sheet_rays::compare(2, i, families, counts);
    EXPECT_EQ(counts.wrong_pixels + counts.wrong_points, before) << "scene " << i;
  }
  EXPECT_GT(counts.cut_scenes, 60);
  EXPECT_GT(counts.pixels, 1500000);
  EXPECT_GT(counts.points, 1500);
}

}  // namespace
}  // namespace tagcal
