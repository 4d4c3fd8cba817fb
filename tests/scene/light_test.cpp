// Lamps, vignetting and depth of field.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "expect.hpp"
#include "random_sheets.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/scene/light/shading.hpp"
#include "tagcal/scene/moving_scene.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using internal::Shading;
using sheet_rays::any_pose;
using sheet_rays::in_cube;

constexpr ImageSize kLitSize{160, 120};

// What the lamp does to the side of a sheet that the eye sees, by the formula.
double expected(const Light& light, Vector3d normal, const Vector3d& x, const Vector3d& to_eye) {
  if (normal.dot(to_eye) < 0) normal = -normal;
  if (const auto* sun = std::get_if<DirectionalLamp>(&light.lamp)) {
    const double cosine = -normal.dot(sun->direction) / sun->direction.norm();
    return light.ambient + sun->strength * std::max(0.0, cosine);
  }
  const auto& lamp = std::get<PointLamp>(light.lamp);
  const Vector3d to_lamp = lamp.position - x;
  const double r = to_lamp.norm();
  return light.ambient + lamp.strength * std::max(0.0, normal.dot(to_lamp) / r) / (r * r);
}

Light random_light(Random& random) {
  Light light{random.uniform(0, 0.5), {}, false};
  if (random.uniform() < 0.3)
    light.lamp = DirectionalLamp{in_cube(random, 2), random.uniform(0, 2)};
  else
    light.lamp = PointLamp{in_cube(random, 1.5), random.uniform(0, 2)};
  return light;
}

TEST(Light, IsTheSameInWorldAndInViewCoordinates) {
  Random random(1);
  int lit = 0;
  for (int i = 0; i < 1000; ++i) {
    const Pose camera_from_world = any_pose(random, 3);
    const Light light = random_light(random);
    const Vector3d normal = in_cube(random, 1).normalized(), x = in_cube(random, 1);
    const Vector3d y = x + 0.5 * normal.cross(in_cube(random, 1));  // on the sheet
    const Shading in_world(light, normal, x);
    const Shading in_view(internal::in_frame(camera_from_world, light),
                          camera_from_world.rotation() * normal, camera_from_world * x);
    const double factor = in_world.at(y);
    EXPECT_NEAR(in_view.at(camera_from_world * y), factor, 1e-11 * factor);
    EXPECT_NEAR(factor, expected(light, normal, y, normal), 1e-11 * factor);
    lit += factor > light.ambient ? 1 : 0;
  }
  EXPECT_GT(lit, 300);
}

// Each pixel away from borders against the formula at the point that an independent ray meets.
void expect_lit_as_rays_say(double blur_px) {
  Random random(7);
  long compared = 0;
  for (std::uint64_t i = 0; i < 40; ++i) {
    Pose pose;
    Scene scene = sheet_rays::random_scene(3, i, pose);
    scene.light = random_light(random);
    scene.sensor.blur_px = blur_px;
    const ImageF light = render_light(scene, {{"tag36h11", tag_family("tag36h11", 1)}}, pose);
    const sheet_rays::RayCaster rays(scene, pose);
    sheet_rays::BorderPixels borders_of(rays, light.size());
    bool cut = false;
    for (const auto& border : sheet_rays::borders(rays.surfaces(), &cut)) borders_of.add(border);
    for (int y = 5; y < kLitSize.height - 5; ++y)
      for (int x = 5; x < kLitSize.width - 5; ++x) {
        bool near = false;
        for (int v = -3; v <= 3; ++v)
          for (int u = -3; u <= 3; ++u) near = near || borders_of.near(x + u, y + v);
        for (const auto& [u, v] : {std::pair(-4, -4), {4, -4}, {-4, 4}, {4, 4}})
          near = near || !rays.ray({x + u, y + v});  // beyond the lens
        if (near) continue;
        const Ray ray = *rays.ray({x, y});
        const sheet_rays::Surface* seen = rays.first(ray);
        if (!seen) {
          ASSERT_NEAR(light(x, y), scene.background_level, 1e-5);
          continue;
        }
        const double t =
            seen->normal.dot(seen->corners[0] - ray.origin) / seen->normal.dot(ray.direction);
        const double level = seen->level * expected(*scene.light, seen->normal,
                                                    ray.origin + t * ray.direction, -ray.direction);
        // Blurred, a pixel is the mean of a neighbourhood in which the shading is curved.
        const double most = blur_px > 0 ? 0.02 : 2e-5;
        ASSERT_NEAR(light(x, y) / level, 1, most) << "scene " << i << ": " << x << " " << y;
        ++compared;
      }
  }
  EXPECT_GT(compared, 60000);
}

TEST(Light, PixelsAreLitAsRaysSay) { expect_lit_as_rays_say(0); }
TEST(Light, BlurredPixelsAreLitAsRaysSay) { expect_lit_as_rays_say(0.5); }

Scene wall(double level) {
  Scene scene;
  scene.camera = {pinhole(100, 100, 79.5, 59.5), kLitSize};
  scene.occluders = {{{{-2, -2, 1}, {2, -2, 1}, {2, 2, 1}, {-2, 2, 1}}, level}};
  return scene;
}

TEST(Light, StrengthIsTheFactorAtOneMetreFacingTheLamp) {
  Scene scene = wall(0.5);
  scene.camera.lens = pinhole(100, 100, 80, 60);
  scene.light = Light{0.125, PointLamp{{0, 0, 0}, 0.5}, true};
  EXPECT_NEAR(render_light(scene, {}, Pose())(80, 60), 0.5 * 0.625, 1e-6);
  scene.light = Light{0.125, PointLamp{{0, 0, 2}, 0.5}, true};  // behind the wall
  EXPECT_NEAR(render_light(scene, {}, Pose())(80, 60), 0.5 * 0.125, 1e-6);
  scene.light = Light{0.125, DirectionalLamp{{0, 3, 3}, 0.5}, true};
  EXPECT_NEAR(render_light(scene, {}, Pose())(80, 60), 0.5 * (0.125 + 0.5 * std::sqrt(0.5)), 1e-6);
  scene.light = Light{0.125, {}, false};
  EXPECT_NEAR(render_light(scene, {}, Pose())(80, 60), 0.5 * 0.125, 1e-6);
}

TEST(Light, ALampMovesWithItsFrameOrTheCamera) {
  MovingScene moving;
  moving.settings = wall(0.5);
  moving.settings.num_views = 3;
  moving.settings.path = FunctionPath{[](double) { return Pose(); }, {}};
  moving.settings.light = Light{0, PointLamp{{0, 0, 0.5}, 0.3}, false};
  moving.frames = {{"rail", "world",
                    [](double t) {
                      return affine(translation({t - 0.5, 0, 0}));
                    },
                    true}};
  moving.light_frame = "rail";
  const auto brightest = [&](const Scene& scene, const Pose& pose) {
    const ImageF light = render_light(scene, {}, pose);
    return static_cast<int>(std::max_element(light.row(59), light.row(59) + kLitSize.width) -
                            light.row(59));
  };
  EXPECT_NEAR(brightest(scene_in_view(moving, 0), Pose()), 29.5, 1);
  EXPECT_NEAR(brightest(scene_in_view(moving, 1), Pose()), 79.5, 1);
  EXPECT_NEAR(brightest(scene_in_view(moving, 2), Pose()), 129.5, 1);

  Scene scene = scene_in_view(moving, 1);
  const Pose aside(Eigen::Quaterniond::Identity(), {-0.3, 0, 0});  // the eye at x = 0.3
  EXPECT_NEAR(brightest(scene, aside), 49.5, 1);
  scene.light->on_camera = true;
  EXPECT_NEAR(brightest(scene, aside), 79.5, 1);
}

TEST(Vignetting, MultipliesTheLightOfEachPixel) {
  Scene scene = wall(0.5);
  scene.camera.lens = Perspective({100, 110, 70, 65, -0.1, 0.02});
  scene.sensor.blur_px = 0.7;
  const ImageF plain = render_light(scene, {}, Pose());
  scene.sensor.vignetting.cos4 = true;
  const ImageF cos4 = render_light(scene, {}, Pose());
  scene.sensor.vignetting = {false, {-0.3, -0.2, 0.1}};
  const ImageF polynomial = render_light(scene, {}, Pose());
  for (int y = 0; y < kLitSize.height; y += 7)
    for (int x = 0; x < kLitSize.width; x += 7) {
      const Vector3d d = ray_in_camera(scene.camera.lens, {x, y})->direction;
      const double angle = std::atan2(std::hypot(d.x(), d.y()), d.z());
      EXPECT_NEAR(cos4(x, y), plain(x, y) * std::pow(std::cos(angle), 4), 1e-6);
      const double r2 = (std::pow(x - 79.5, 2) + std::pow(y - 59.5, 2)) / (80 * 80 + 60 * 60);
      const double factor = 1 - 0.3 * r2 - 0.2 * r2 * r2 + 0.1 * r2 * r2 * r2;
      EXPECT_NEAR(polynomial(x, y), plain(x, y) * factor, 1e-6);
    }
}

TEST(Vignetting, ThatACameraCannotHaveIsAnError) {
  const Camera camera{pinhole(100, 100, 79.5, 59.5), kLitSize};
  const auto refused = [](const Camera& c, const Vignetting& v) {
    Sensor sensor;
    sensor.vignetting = v;
    return error_of([&] { check_sensor(c, sensor); }) != "no error";
  };
  EXPECT_FALSE(refused(camera, {false, {-0.9}}));
  EXPECT_TRUE(refused(camera, {false, {-1.1}}));
  EXPECT_TRUE(refused(camera, {false, {-4.5, 4.4}}));  // in the middle only
  EXPECT_FALSE(refused(camera, {true, {}}));
  EXPECT_FALSE(refused({Fisheye({70, 70, 79.5, 59.5, 0, 0, 0, 0}), kLitSize}, {true, {}}));
  EXPECT_TRUE(refused({Fisheye({60, 60, 79.5, 59.5, 0, 0, 0, 0}), kLitSize}, {true, {}}));
}

// The share of a half-plane beyond `place` in a pixel, blurred by a Gaussian.
double blurred_step(double pixel, double place, double sigma) {
  const auto integral = [sigma](double x) {  // of the normal distribution function
    const double t = x / sigma;
    return sigma * (t * 0.5 * std::erfc(-t / std::sqrt(2)) +
                    std::exp(-0.5 * t * t) / std::sqrt(2 * std::numbers::pi));
  };
  return integral(pixel + 0.5 - place) - integral(pixel - 0.5 - place);
}

Occluder half_plane(double x, double z, double level) {
  return {{{x, -9, z}, {9, -9, z}, {9, 9, z}, {x, 9, z}}, level};
}

TEST(Focus, EdgesOfSheetsParallelToTheImageHaveTheBlurOfTheirDepth) {
  for (const double z : {0.5, 0.8, 1.0, 1.3, 4.0})
    for (const double sensor_blur : {0.0, 0.6}) {
      Scene scene;
      scene.camera = {pinhole(200, 200, 79.5, 59.5), kLitSize};
      scene.background_level = 0.2;
      scene.occluders = {half_plane(0.013 * z, z, 0.8)};
      scene.sensor.blur_px = sensor_blur;
      scene.sensor.focus = Focus{1, 0.05 / 1.4};
      const double defocus = 0.05 / 1.4 * 200 * std::abs(1 / z - 1) / 4;
      const double sigma = std::max(1e-3, std::hypot(defocus, sensor_blur));
      const ImageF light = render_light(scene, {}, Pose());
      for (int x = 0; x < kLitSize.width; ++x)
        EXPECT_NEAR(light(x, 60), 0.2 + 0.6 * blurred_step(x, 79.5 + 2.6, sigma), 1e-3)
            << "z " << z << " x " << x << " sigma " << sigma;
    }
}

// A near edge, blurred over a sharp edge behind it, and the other way round.
TEST(Focus, ABlurredBorderShowsWhatIsBehindIt) {
  for (const bool sharp_near : {false, true}) {
    Scene scene;
    scene.camera = {pinhole(200, 200, 79.5, 59.5), kLitSize};
    scene.background_level = 0.2;
    scene.occluders = {half_plane(0, 1, 0.9), half_plane(0.005, 0.5, 0.4)};
    scene.sensor.focus = Focus{sharp_near ? 0.5 : 1.0, 0.03};
    const double sigma = 0.03 * 200 / 4;
    const ImageF light = render_light(scene, {}, Pose());
    for (int x = 0; x < kLitSize.width; ++x) {
      const double far = blurred_step(x, 79.5, sharp_near ? sigma : 1e-3);
      const double near = blurred_step(x, 79.5 + 2, sharp_near ? 1e-3 : sigma);
      EXPECT_NEAR(light(x, 60), near * 0.4 + (1 - near) * (far * 0.9 + (1 - far) * 0.2), 1e-3) << x;
    }
  }
}

// The edge of a floor that recedes: each row has the blur of its depth.
TEST(Focus, ATiltedSheetIsBlurredByTheDepthOfEachPixel) {
  Scene scene;
  scene.camera = {pinhole(200, 200, 79.5, 59.5), {160, 240}};
  scene.camera.lens = pinhole(200, 200, 79.5, 19.5);
  scene.background_level = 0.1;
  scene.occluders = {{{{0, 0.5, 0.1}, {9, 0.5, 0.1}, {9, 0.5, 9}, {0, 0.5, 9}}, 0.9}};
  scene.sensor.focus = Focus{0.7, 0.02};
  const ImageF light = render_light(scene, {}, Pose());
  for (int y = 70; y < 230; y += 4) {  // depths from 0.48 to 2 m
    const double sigma = 0.02 * 200 / 4 * std::abs((y - 19.5) / 100 - 1 / 0.7);
    for (int x = 60; x < 100; ++x)
      EXPECT_NEAR(light(x, y), 0.1 + 0.8 * blurred_step(x, 79.5, std::max(sigma, 1e-3)), 0.01)
          << x << " " << y << " " << sigma;
  }
}

// Two sheets of one level meet in an edge that points at the camera, before a dark background. The
// edge does not show, however it is blurred.
TEST(Focus, TheCommonEdgeOfTwoSheetsDoesNotShow) {
  Scene scene;
  scene.camera = {pinhole(200, 200, 79.5, 59.5), kLitSize};
  scene.background_level = 0.1;
  const Vector3d above(0, -0.3, 0.8), below(0, 0.3, 0.8);
  for (const Vector3d& away : {Vector3d(0.2, 0, 0.3), Vector3d(-0.25, 0, 0.2)})
    scene.occluders.push_back({{above, below, below + away, above + away}, 0.7});
  for (const double distance_m : {0.5, 0.75, 2.0}) {
    scene.sensor.focus = Focus{distance_m, 0.02};
    const ImageF light = render_light(scene, {}, Pose());
    for (int x = 60; x < 100; ++x) ASSERT_NEAR(light(x, 60), 0.7, 1e-3) << distance_m << " " << x;
    EXPECT_NEAR(light(0, 60), 0.1, 1e-6);
  }
}

// Away from borders nothing changes, whatever hides what.
TEST(Focus, RandomSheetsKeepTheirLevels) {
  const TagFamilies families = {{"tag36h11", tag_family("tag36h11", 1)}};
  sheet_rays::Counts counts;
  for (std::uint64_t i = 0; i < 40; ++i) {
    Pose pose;
    Scene scene = sheet_rays::random_scene(5, i, pose);
    if (!std::holds_alternative<Perspective>(scene.camera.lens)) continue;
    scene.sensor.focus = Focus{1, 1e-5};  // a disc far below a pixel
    const long before = counts.wrong_pixels;
    sheet_rays::compare_pixels(scene, render_light(scene, families, pose),
                               sheet_rays::RayCaster(scene, pose), counts);
    EXPECT_EQ(counts.wrong_pixels, before) << "scene " << i;
  }
  EXPECT_GT(counts.pixels, 200000);
  EXPECT_GT(counts.cut_scenes, 5);
}

TEST(Focus, NeedsAPerspective) {
  Scene scene = wall(0.5);
  scene.camera.lens = Fisheye({60, 60, 79.5, 59.5, 0, 0, 0, 0});
  scene.sensor.focus = Focus{1, 0.01};
  EXPECT_THROW(render_light(scene, {}, Pose()), Error);
}

// Away from borders and in the depth of the nearest sheet along the ray.
TEST(Depth, IsThatOfTheRayThroughThePixelsCentre) {
  long compared = 0, nothing = 0;
  for (std::uint64_t i = 0; i < 100; ++i) {
    Pose pose;
    const Scene scene = sheet_rays::random_scene(11, i, pose);
    const ImageF depth = render_depth(scene, pose);
    const sheet_rays::RayCaster rays(scene, pose);
    for (int y = 0; y < kLitSize.height; ++y)
      for (int x = 0; x < kLitSize.width; ++x) {
        const auto ray = rays.ray({x, y});
        const auto* seen = ray ? rays.first(*ray) : nullptr;
        if (!seen) {
          ASSERT_TRUE(std::isnan(depth(x, y))) << "scene " << i << ": " << x << " " << y;
          ++nothing;
          continue;
        }
        const double t =
            seen->normal.dot(seen->corners[0] - ray->origin) / seen->normal.dot(ray->direction);
        const double z = (pose * (ray->origin + t * ray->direction)).z();
        ASSERT_NEAR(depth(x, y), z, 1e-5) << "scene " << i << ": " << x << " " << y;
        ++compared;
      }
  }
  EXPECT_GT(compared, 300000);
  EXPECT_GT(nothing, 100000);
}

// The image is moved so that a corner lies in the middle of a pixel.
TEST(Depth, OfVisibleCornersIsTheirs) {
  Random random(3);
  int compared = 0;
  for (int i = 0; i < 20; ++i) {
    Scene scene;
    scene.camera = {pinhole(200, 200, 79.5, 59.5), kLitSize};
    scene.boards = {{make_board(AprilGrid{4, 3, 0.06, 0.3, 0, "tag36h11", 1, false}), Pose()}};
    scene.occluders = {{{{0.1, 0, 0.1}, {0.2, 0, 0.1}, {0.2, 0.1, 0.15}, {0.1, 0.1, 0.15}}, 0.3}};
    const Pose pose = camera_from_world_looking_at(
        {random.uniform(-0.2, 0.5), random.uniform(-0.3, 0.4), 0.7}, {0.14, 0.1, 0}, {0, 1, 0});
    const auto points = points_in_world(scene.boards);
    for (const Observation& corner : visible_corners(scene, pose)) {
      const Vector2d middle(std::round(corner.pixel.x()), std::round(corner.pixel.y()));
      const Vector2d shift = middle - corner.pixel;
      if (!contains(kLitSize, middle)) continue;
      Scene moved = scene;
      moved.camera.lens = pinhole(200, 200, 79.5 + shift.x(), 59.5 + shift.y());
      const ImageF depth = render_depth(moved, pose);
      EXPECT_NEAR(depth(static_cast<int>(middle.x()), static_cast<int>(middle.y())),
                  (pose * points.at(corner.id)).z(), 1e-6);
      ++compared;
    }
  }
  EXPECT_GT(compared, 500);
}

TEST(Depth, LevelsAreWholeUnitsOrZero) {
  ImageF depth({7, 1});
  const float metres[] = {
      std::numeric_limits<float>::quiet_NaN(), -1, 0.0004f, 0.0006f, 1.2346f, 65.535f, 65.536f};
  std::copy_n(metres, 7, depth.row(0));
  std::size_t num_beyond = 0;
  EXPECT_EQ(depth_levels(depth, 0.001, &num_beyond).pixels(),
            (std::vector<std::uint16_t>{0, 0, 0, 1, 1235, 65535, 0}));
  EXPECT_EQ(num_beyond, 3U);
}

}  // namespace
}  // namespace tagcal
