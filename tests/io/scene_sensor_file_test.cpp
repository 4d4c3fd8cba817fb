// What a scene file says of light, lens, sensor and motion.
#include <gtest/gtest.h>

#include <numbers>

#include "scene_file_fixture.hpp"

namespace tagcal {
namespace {

TEST_F(SceneFile, ReadsLightVignettingAndFocus) {
  const auto with = [](const std::string& sensor, const std::string& light) {
    return replaced(kScene, "gamma: 0.45}\n", "gamma: 0.45" + sensor + "}\n" + light);
  };
  Scene scene = read(kScene);
  EXPECT_FALSE(scene.light || scene.sensor.focus || scene.sensor.vignetting.cos4);
  EXPECT_TRUE(scene.sensor.vignetting.polynomial.empty());
  scene = read(with(", vignetting: cos4, focus: {distance_m: 0.9, f_number: 2, focal_mm: 35}",
                    "light: {ambient: 0.2, point: {position_m: [1, 2, 3], strength: 4}}\n"));
  EXPECT_TRUE(scene.sensor.vignetting.cos4);
  EXPECT_EQ(scene.sensor.focus->distance_m, 0.9);
  EXPECT_DOUBLE_EQ(scene.sensor.focus->aperture_m, 0.0175);
  EXPECT_EQ(scene.light->ambient, 0.2);
  EXPECT_EQ(std::get<PointLamp>(scene.light->lamp).position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(std::get<PointLamp>(scene.light->lamp).strength, 4);
  EXPECT_FALSE(scene.light->on_camera);
  scene =
      read(with(", vignetting: [-0.3, 0.1]",
                "light: {on_camera: true, directional: {direction: [0, 0, 1], strength: 2}}\n"));
  EXPECT_EQ(scene.sensor.vignetting.polynomial, (std::vector<double>{-0.3, 0.1}));
  EXPECT_EQ(std::get<DirectionalLamp>(scene.light->lamp).direction, Eigen::Vector3d::UnitZ());
  EXPECT_TRUE(scene.light->on_camera);
  EXPECT_EQ(scene.light->ambient, 0);
  scene = read(with("",
                    "frames: [{name: pole, pose: {translation_m: [0, 0, 2]}}]\n"
                    "light: {frame: pole, point: {position_m: [1, 0, 0], strength: 1}}\n"));
  EXPECT_EQ(std::get<PointLamp>(scene.light->lamp).position, Eigen::Vector3d(1, 0, 2));

  struct Bad {
    std::string sensor, light, message;
  };
  const std::string point = "point: {position_m: [0, 0, 1], strength: 1}";
  const std::string focus = "f_number: 2, focal_mm: 35}";
  const Bad table[] = {
      {"", "light: {directional: {direction: [0, 0, 0], strength: 1}}",
       "scene.yaml: light.directional.direction: must not be zero"},
      {"", "light: {directional: {direction: [0, 0, 1], strength: -1}}",
       "scene.yaml: light.directional.strength: must be >= 0, got -1"},
      {"", "light: {directional: {direction: [0, 0, 1]}}",
       "scene.yaml: light.directional.strength: the key is missing"},
      {"", "light: {point: {position_m: [0, 0, 1], strength: -2}}",
       "scene.yaml: light.point.strength: must be >= 0, got -2"},
      {"", "light: {ambient: -0.1}", "scene.yaml: light.ambient: must be >= 0, got -0.1"},
      {"", "light: {" + point + ", directional: {direction: [0, 0, 1], strength: 1}}",
       "scene.yaml: light.point: does not go with directional"},
      {"", "light: {" + point + ", frame: nowhere}", "scene.yaml: light.frame: "},
      {"", "light: {" + point + ", frame: world, on_camera: true}",
       "scene.yaml: light.frame: does not go with on_camera"},
      {"", "light: {lamp: 1}", "scene.yaml: light.lamp: unknown key"},
      {", vignetting: [-1.2]", "",
       "scene.yaml: sensor: vignetting: must not be negative in the image, got -0.1"},
      {", vignetting: cos3", "", "scene.yaml: sensor.vignetting: must be cos4 or a list"},
      {", focus: {distance_m: 0, " + focus, "",
       "scene.yaml: sensor.focus.distance_m: must be above the focal length, 0.035 m, got 0"},
      {", focus: {distance_m: 1, f_number: 0, focal_mm: 35}", "",
       "scene.yaml: sensor.focus.f_number: must be > 0, got 0"},
      {", focus: {distance_m: 1, f_number: 2}", "",
       "scene.yaml: sensor.focus.focal_mm: the key is missing"}};
  for (const Bad& bad : table) expect_line(error(with(bad.sensor, bad.light + "\n")), bad.message);
  const std::string fisheye =
      replaced(with(", focus: {distance_m: 1, " + focus, ""), "model: opencv5", "model: fisheye4");
  EXPECT_EQ(error(fisheye),
            "scene.yaml: sensor: focus: needs a perspective lens, not a fisheye one");
}

TEST_F(SceneFile, ReadsWhatTheSensorDoesToItsPictures) {
  const auto with = [](const std::string& keys) {
    return replaced(kScene, "bits: 16, gamma: 0.45", "gamma: 0.45" + keys);
  };
  Scene scene = read(kScene);
  EXPECT_FALSE(scene.sensor.mosaic || scene.sensor.denoise || scene.sensor.sharpen ||
               scene.sensor.jpeg);
  EXPECT_EQ(scene.print_grid_m, 0);
  scene = read(with(", mosaic: {pattern: GBRG, gains: [0.5, 1, 0.7], demosaic: false}, denoise: "
                    "{levels: 6, radius_px: 1.5}, sharpen: {amount: 0.8, radius_px: 2}, jpeg: 75") +
               "print_grid_m: 0.001\n");
  EXPECT_EQ(scene.sensor.mosaic->pattern, "GBRG");
  EXPECT_EQ(scene.sensor.mosaic->gains, (std::array<double, 3>{0.5, 1, 0.7}));
  EXPECT_FALSE(scene.sensor.mosaic->demosaic);
  EXPECT_EQ(scene.sensor.denoise->levels, 6);
  EXPECT_EQ(scene.sensor.denoise->radius_px, 1.5);
  EXPECT_EQ(scene.sensor.sharpen->amount, 0.8);
  EXPECT_EQ(scene.sensor.sharpen->radius_px, 2);
  EXPECT_EQ(scene.sensor.jpeg, 75);
  EXPECT_EQ(scene.print_grid_m, 0.001);
  scene = read(with(", mosaic: {pattern: RGGB}"));
  EXPECT_EQ(scene.sensor.mosaic->gains, (std::array<double, 3>{1, 1, 1}));
  EXPECT_TRUE(scene.sensor.mosaic->demosaic);

  const std::pair<std::string, std::string> table[] = {
      {"mosaic: {pattern: RGBG}",
       "sensor: mosaic: pattern: must be RGGB, BGGR, GRBG or GBRG, got RGBG"},
      {"mosaic: {gains: [1, 1, 1]}", "sensor.mosaic.pattern: the key is missing"},
      {"mosaic: {pattern: RGGB, gains: [1, 1]}", "sensor.mosaic.gains: must "},
      {"mosaic: {pattern: RGGB, gains: [1, -1, 1]}",
       "sensor: mosaic: gains: must be above 0 and at most 100, got -1"},
      {"mosaic: {pattern: RGGB, gain: 1}", "sensor.mosaic.gain: unknown key; did you mean gains?"},
      {"denoise: {levels: 0, radius_px: 1}",
       "sensor: denoise: levels: must be above 0 and at most 255, got 0"},
      {"denoise: {levels: 5}", "sensor.denoise.radius_px: the key is missing"},
      {"sharpen: {amount: 11, radius_px: 1}",
       "sensor: sharpen: amount: must be from 0 to 10, got 11"},
      {"sharpen: 1", "sensor.sharpen: must "},
      {"jpeg: 0", "sensor.jpeg: must be a whole number from 1 to 100, got 0"},
      {"jpeg: 80, bits: 16", "sensor: jpeg: has 8 bits only; leave out `bits: 16`"}};
  for (const auto& [keys, start] : table)
    expect_line(error(with(", " + keys)), "scene.yaml: " + start);
  EXPECT_EQ(error(kScene + "print_grid_m: -1\n"), "scene.yaml: print_grid_m: must be >= 0, got -1");
}

const std::string kLine =
    "path: {type: line, from_m: [0, 0, 1], to_m: [1, 0, 1]}\nviews: 3\nsensor: {readout_ms: 20, "
    "direction: up}\n";

TEST_F(SceneFile, ReadsARollingShutterAndTheMotionOfTheCamera) {
  const std::string boards = kScene.substr(0, kScene.find("path:"));
  const MovingScene scene = read_moving_scene(
      write("scene.yaml", boards + kLine +
                              "period_ms: 50\nvelocity: {turn_deg_s: [[0, 0, 0], [0, 0, "
                              "90]], move_m_s: [0, 2, 0]}\n"),
      &warnings_);
  EXPECT_EQ(scene.settings.sensor.shutter.readout_s, 0.02);
  EXPECT_EQ(scene.settings.sensor.shutter.direction, ReadDirection::up);
  EXPECT_EQ(scene.period_s, 0.05);
  EXPECT_NEAR(scene.velocity(0.5).turn_rad_s.z(), std::numbers::pi / 4, 1e-15);
  EXPECT_EQ(scene.velocity(1).move_m_s, Eigen::Vector3d(0, 2, 0));
  // 1 m in 0.1 s, and what is stated.
  EXPECT_NEAR((scene_in_view(scene, 1).velocity.move_m_s - Eigen::Vector3d(0, 2, 0)).norm(), 10,
              1e-4);
}

TEST_F(SceneFile, RefusesMotionsThatItCannotHave) {
  const std::string boards = kScene.substr(0, kScene.find("path:"));
  EXPECT_EQ(error(kScene + "period_ms: 50\n"),
            "scene.yaml: period_ms: needs a path with one view after another, not dome or poses: "
            "state the velocity");
  EXPECT_EQ(error(boards + kLine + "period_ms: 0\n"), "scene.yaml: period_ms: must be > 0, got 0");
  EXPECT_EQ(error(boards + kLine + "velocity: {turn_deg: [0, 0, 1]}\n"),
            "scene.yaml: velocity.turn_deg: unknown key; did you mean turn_deg_s?");
  EXPECT_EQ(error(boards + "path: {type: line, from_m: [0, 0, 1], to_m: [1, 0, 1]}\nviews: 3\n"
                           "sensor: {direction: up}\n"),
            "scene.yaml: sensor.direction: belongs to readout_ms");
  EXPECT_EQ(error(boards + "path: {type: line, from_m: [0, 0, 1], to_m: [1, 0, 1]}\nviews: 3\n"
                           "sensor: {readout_ms: 9, direction: in}\n"),
            "scene.yaml: sensor.direction: must be down, up, right or left, got in");
}

}  // namespace
}  // namespace tagcal
