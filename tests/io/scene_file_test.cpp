#include "tagcal/io/scene_file.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <numbers>

#include "file_fixture.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/target_file.hpp"

namespace tagcal {
namespace {

const std::string kTarget =
    "target_type: aprilgrid\ntagCols: 2\ntagRows: 2\ntagSize: 0.1\ntagSpacing: 0.25\n";
const std::string kScene =
    "camera:\n  image_size: [640, 480]\n  model: opencv5\n  fx: 500\n  fy: 501\n  cx: 320\n"
    "  distortion: [-0.1, 0.01]\n"
    "boards:\n  - file: target.yaml\n"
    "  - {target: {target_type: tags, tags: [{id: 9, size: 0.2}]}, first_id: 20,\n"
    "     world_from_board: {translation_m: [1, 2, 3]}}\n"
    "occluders:\n  - {corners: [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], level: 0.4}\n"
    "path:\n  type: dome\n  min_distance_m: 0.5\n  max_distance_m: 1.5\n  min_elevation_deg: 30\n"
    "views: 7\n"
    "jitter: {position_m: 0.1, target_m: 0.2, roll_deg: 90}\n"
    "sensor: {exposure: 1.1, blur_px: 0.7, noise_levels: 2, bits: 16, gamma: 0.45}\n"
    "background_level: 0.1\npaper_level: 1\nink_level: 0\nink_spread_m: -0.0002\n"
    "paper_margin_m: 0.05\n";

class SceneFile : public FileTest {
 protected:
  SceneFile() { write("target.yaml", kTarget); }

  Scene read(const std::string& text) { return read_scene(write("scene.yaml", text), &warnings_); }
  std::string error(const std::string& text) {
    const std::string message = error_of([&] { read(text); });
    const std::string name = folder_.string() + "/";
    return message.starts_with(name) ? message.substr(name.size()) : "names no file: " + message;
  }
  Scene with_path(const std::string& path) {
    const std::size_t begin = kScene.find("path:"), end = kScene.find("jitter:");
    return read(kScene.substr(0, begin) + path + kScene.substr(end));
  }
  Scene with_camera(const std::string& camera) {
    return read("camera: " + camera + "\n" + kScene.substr(kScene.find("boards:")));
  }

  std::vector<std::string> warnings_;
};

TEST_F(SceneFile, ReadsEveryKey) {
  const Scene scene = read(kScene);
  const auto p = parameters(scene.camera.lens);
  EXPECT_EQ(scene.model, "opencv5");
  EXPECT_EQ(scene.camera.image_size, (ImageSize{640, 480}));
  EXPECT_EQ((std::vector<double>(p.begin(), p.end())),
            (std::vector<double>{500, 501, 320, 239.5, -0.1, 0.01, 0, 0, 0, 0, 0, 0}));
  ASSERT_EQ(scene.boards.size(), 2U);
  EXPECT_EQ(tags_of(scene.boards[0].board).size(), 4U);
  EXPECT_EQ(tags_of(scene.boards[1].board)[0].id, 20);
  EXPECT_EQ(scene.boards[1].world_from_board.translation(), Eigen::Vector3d(1, 2, 3));
  ASSERT_EQ(scene.occluders.size(), 1U);
  EXPECT_EQ(scene.occluders[0].corners[2], Eigen::Vector3d(1, 1, 1));
  EXPECT_EQ(scene.occluders[0].level, 0.4);
  const auto& path = std::get<DomePath>(scene.path);
  EXPECT_EQ(path.min_distance_m, 0.5);
  EXPECT_EQ(path.max_distance_m, 1.5);
  EXPECT_EQ(path.max_azimuth_rad, 2 * std::numbers::pi);
  EXPECT_NEAR(path.min_elevation_rad, std::numbers::pi / 6, 1e-15);
  EXPECT_EQ(path.max_elevation_rad, std::numbers::pi / 2);
  EXPECT_EQ(scene.num_views, 7);
  EXPECT_EQ(scene.jitter.position_m, 0.1);
  EXPECT_EQ(scene.jitter.target_m, 0.2);
  EXPECT_EQ(scene.jitter.roll_rad, std::numbers::pi / 2);
  EXPECT_EQ(scene.sensor.exposure, 1.1);
  EXPECT_EQ(scene.sensor.blur_px, 0.7);
  EXPECT_EQ(scene.sensor.noise_levels, 2);
  EXPECT_EQ(scene.sensor.bits, 16);
  EXPECT_EQ(scene.sensor.gamma, 0.45);
  EXPECT_EQ(scene.ink_spread_m, -0.0002);
  EXPECT_EQ(scene.background_level, 0.1);
  EXPECT_EQ(scene.paper_level, 1);
  EXPECT_EQ(scene.ink_level, 0);
  EXPECT_EQ(scene.paper_margin_m, 0.05);
}

TEST_F(SceneFile, DefaultsAreThoseOfTheHeader) {
  const Scene scene = read(
      "camera: {image_size: [640, 480], model: f, f: 500}\nboards: [target.yaml]\n"
      "path: {type: ring, radius_m: 2}\nviews: 3\n");
  EXPECT_EQ(scene.paper_level, 0.9);
  EXPECT_EQ(scene.paper_margin_m, 0.02);
  EXPECT_EQ(scene.background_level, 0.5);
  EXPECT_EQ(scene.ink_level, 0.1);
  EXPECT_EQ(scene.sensor.exposure, 1);
  EXPECT_EQ(scene.sensor.noise_levels, 0);
  EXPECT_EQ(scene.sensor.bits, 8);
  EXPECT_EQ(scene.sensor.gamma, 1);
  EXPECT_EQ(scene.ink_spread_m, 0);
  EXPECT_TRUE(scene.occluders.empty());
  EXPECT_EQ(std::get<RingPath>(scene.path).end_rad, 2 * std::numbers::pi);
  EXPECT_EQ(parameters(scene.camera.lens)[2], 319.5);
}

TEST_F(SceneFile, Paths) {
  const auto ring = std::get<RingPath>(
      with_path("path: {type: ring, centre_m: [1, 2, 3], radius_m: 2, start_deg: -90, end_deg: 90, "
                "target_m: [4, 5, 6]}\nviews: 3\n")
          .path);
  EXPECT_EQ(ring.centre, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(ring.start_rad, -std::numbers::pi / 2);
  EXPECT_EQ(ring.end_rad, std::numbers::pi / 2);
  EXPECT_EQ(ring.target, Eigen::Vector3d(4, 5, 6));
  const auto line = std::get<LinePath>(
      with_path("path: {type: line, from_m: [1, 2, 3], to_m: [4, 5, 6]}\nviews: 3\n").path);
  EXPECT_EQ(line.to, Eigen::Vector3d(4, 5, 6));
  const Scene poses =
      with_path("path: {type: poses, camera_from_world: [{}, {rotation: [0, 1, 0, 0]}]}\n");
  EXPECT_EQ(poses.num_views, 2);
  EXPECT_EQ(std::get<ExplicitPath>(poses.path).camera_from_world[1].rotation().x(), 1);
}

TEST_F(SceneFile, FieldOfViewSpansTheWidth) {
  Scene scene = with_camera("{image_size: [640, 480], model: f, field_of_view_deg: 90}");
  EXPECT_NEAR(parameters(scene.camera.lens)[0], 320, 1e-12);
  EXPECT_NEAR(parameters(scene.camera.lens)[1], 320, 1e-12);
  scene = with_camera("{image_size: [640, 480], model: fisheye4, field_of_view_deg: 180}");
  EXPECT_TRUE(std::holds_alternative<Fisheye>(scene.camera.lens));
  EXPECT_NEAR(parameters(scene.camera.lens)[0], 640 / std::numbers::pi, 1e-12);
}

TEST_F(SceneFile, UnknownKeysOfATargetFileWarnButOfAnInlineTargetDoNot) {
  write("target.yaml", kTarget + "colour: red\n");
  read(kScene);
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_NE(warnings_[0].find("target.yaml: colour: unknown key"), std::string::npos);
  EXPECT_EQ(error(replaced(kScene, "target_type: tags, tags: [{id: 9, size: 0.2}]",
                           "target_type: aprilgrid, tagCols: 1, tagRows: 1, tagSize: 1, "
                           "tagSpacing: 0, colour: red"))
                .substr(0, 53),
            "scene.yaml: boards[1].target.colour: unknown key; kno");
}

TEST_F(SceneFile, BadScenes) {
  const std::vector<BadFile> table = {
      {"  fy: 501\n", "", "scene.yaml: camera.fy: the key is missing"},
      {"fx: 500", "f: 500", "scene.yaml: camera: needs one of f, fx and fy, field_of_view_deg"},
      {"  fx: 500\n  fy: 501\n", "", "scene.yaml: camera: needs one of f, fx and fy, field_of_vi"},
      {"fx: 500", "fx: 0", "scene.yaml: camera.fx: must be > 0, got 0"},
      {"fx: 500", "focal: 500", "scene.yaml: camera.focal: unknown key"},
      {"  fx: 500\n  fy: 501\n", "  field_of_view_deg: 180\n",
       "scene.yaml: camera.field_of_view_deg: must be below 180, got 180"},
      {"model: opencv5", "model: weak", "scene.yaml: camera.model: must be one of f, f+c, pinhole"},
      {"model: opencv5", "model: radial1",
       "scene.yaml: camera.distortion: must have at most the 1"},
      {"model: opencv5", "model: pinhole",
       "scene.yaml: camera.distortion: must have at most the 0"},
      {"model: opencv5", "model: radial2",
       "scene.yaml: camera: fx and fy must be equal with model"},
      {"[-0.1, 0.01]", "[1, 2, 3, 4, 5, 6]", "scene.yaml: camera.distortion: must have at most th"},
      {"[640, 480]", "[640, 4e2]", "scene.yaml: camera.image_size[1]: must be a whole number from"},
      {"cx: 320", "cx: ~", "scene.yaml: camera.cx: must be a finite number, got nothing"},
      {"file: target.yaml", "file: none.yaml", "none.yaml: no such file"},
      {"- file: target.yaml", "- {first_id: 3}", "scene.yaml: boards[0].file: the key is missing"},
      {"- file: target.yaml", "- {file: a, target: {target_type: tags, tags: [{id: 1, size: 1}]}}",
       "scene.yaml: boards[0]: has a file and a target, but needs one of them"},
      {"size: 0.2", "size: -0.2", "scene.yaml: boards[1].target.tags[0].size: must be > 0, got -0"},
      {"first_id: 20", "first_id: 3",
       "scene.yaml: boards: ids must be unique over all boards, but"},
      {"world_from_board", "board_from_world", "scene.yaml: boards[1].board_from_world: unknown k"},
      {"level: 0.4", "level: 1.4", "scene.yaml: occluders[0].level: must be from 0 to 1, got 1.4"},
      {"[1, 1, 1], [0, 1, 1]", "[1, 1, 2], [0, 1, 1]",
       "scene.yaml: occluders[0].corners: must lie in a plane"},
      {"[1, 1, 1], [0, 1, 1]", "[0.1, 0.1, 1], [0, 1, 1]",
       "scene.yaml: occluders[0].corners: must be convex"},
      {"[1, 1, 1], [0, 1, 1]", "[0, 1, 1], [0.9, 1, 1]",
       "scene.yaml: occluders[0].corners: must be convex"},
      {"[1, 0, 1], [1, 1, 1], [0, 1, 1]", "[1, 0, 1], [2, 0, 1]",
       "scene.yaml: occluders[0].corners: must not lie on a line"},
      {"[1, 0, 1], [1, 1, 1], [0, 1, 1]", "[1, 1, 1], [1, 0, 1], [0, 1, 1]",
       "scene.yaml: occluders[0].corners: must be convex, but its sides cross"},
      {"[1, 0, 1], [1, 1, 1], [0, 1, 1]", "[1, 0, 1]",
       "scene.yaml: occluders[0].corners: must be a list of at least 3, got a list of 2"},
      {"[[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]",
       "[[0, 1, 0], [0.59, -0.81, 0], [-0.95, 0.31, 0], [0.95, 0.31, 0], [-0.59, -0.81, 0]]",
       "scene.yaml: occluders[0].corners: must be convex, but its sides cross"},
      {"type: dome", "type: spiral",
       "scene.yaml: path.type: must be ring, dome, line, poses, look_at, orbit, aircraft, "},
      {"type: dome", "type: line", "scene.yaml: path.min_distance_m: unknown key"},
      {"min_distance_m: 0.5", "min_distance_m: 2", "scene.yaml: path: min_distance_m: must not be"},
      {"min_distance_m: 0.5", "min_distance_m: 0", "scene.yaml: path.min_distance_m: must be > 0,"},
      {"min_elevation_deg: 30", "min_elevation_deg: 95",
       "scene.yaml: path.min_elevation_deg: must be from -90 to 90, got 95"},
      {"min_elevation_deg", "min_elevation_rad",
       "scene.yaml: path.min_elevation_rad: unknown key; "
       "did you mean min_elevation_deg?"},
      {"views: 7", "views: 0", "scene.yaml: views: must be a whole number from 1 to 100000, got 0"},
      {"views: 7\n", "", "scene.yaml: views: the key is missing"},
      {"roll_deg: 90", "roll_deg: -1",
       "scene.yaml: jitter.roll_deg: must be from 0 to 180, got -1"},
      {"position_m: 0.1", "position_m: -1", "scene.yaml: jitter.position_m: must be >= 0, got -1"},
      {"exposure: 1.1", "exposure: 0", "scene.yaml: sensor.exposure: must be > 0, got 0"},
      {"blur_px: 0.7", "blur_px: -1", "scene.yaml: sensor.blur_px: must be from 0 to 100, got -1"},
      {"noise_levels: 2", "noise_levels: x", "scene.yaml: sensor.noise_levels: must be a finite"},
      {"bits: 16", "bits: 12", "scene.yaml: sensor.bits: must be 8 or 16, got 12"},
      {"bits: 16", "bits: 32", "scene.yaml: sensor.bits: must be 8 or 16, got 32"},
      {"bits: 16", "bits: 8.5", "scene.yaml: sensor.bits: must be 8 or 16, got 8.5"},
      {"gamma: 0.45", "gamma: 0", "scene.yaml: sensor.gamma: must be > 0, got 0"},
      {"gamma: 0.45", "gama: 0.45", "scene.yaml: sensor.gama: unknown key; did you mean gamma?"},
      {"ink_spread_m: -0.0002", "ink_spread_m: thick",
       "scene.yaml: ink_spread_m: must be a finite"},
      {"ink_spread_m: -0.0002", "ink_spread_m: 0.06",
       "scene.yaml: ink_spread_m: must not be above paper_margin_m, 0.05, got 0.06"},
      {"ink_level: 0", "ink_level: -1", "scene.yaml: ink_level: must be from 0 to 1, got -1"},
      {"paper_margin_m: 0.05", "paper_margin_m: -1",
       "scene.yaml: paper_margin_m: must be >= 0, go"},
      {"camera:", "cameras:", "scene.yaml: cameras: unknown key; did you mean camera?"}};
  EXPECT_NO_THROW(read(kScene));
  for (const BadFile& bad : table) {
    const std::string message = error(replaced(kScene, bad.from, bad.to));
    EXPECT_EQ(message.substr(0, bad.message.size()), bad.message) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

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
  for (const Bad& bad : table) {
    const std::string message = error(with(bad.sensor, bad.light + "\n"));
    EXPECT_EQ(message.substr(0, bad.message.size()), bad.message) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
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
  for (const auto& [keys, start] : table) {
    const std::string message = error(with(", " + keys)), expected = "scene.yaml: " + start;
    EXPECT_EQ(message.substr(0, expected.size()), expected) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_EQ(error(kScene + "print_grid_m: -1\n"), "scene.yaml: print_grid_m: must be >= 0, got -1");
}

TEST_F(SceneFile, TheDeskShowsItsBoardAllOverTheImage) {
  const Scene scene = read_scene(fs::path(TAGCAL_SOURCE_DIR) / "data-synthetic/scenes/desk.yaml");
  EXPECT_EQ(scene.num_views, 24);
  const auto points = points_in_world(scene.boards);
  ASSERT_EQ(points.size(), 144U);
  const ImageSize& size = scene.camera.image_size;
  int in_corner[4] = {};  // seen within a tenth of width and height of each corner of the image
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    for (const Pose& camera_from_world : camera_poses(scene, seed)) {
      int num_seen = 0;
      for (const auto& [id, x_in_world] : points) {
        const auto pixel = project(scene.camera.lens, camera_from_world * x_in_world);
        if (!pixel || !contains(size, *pixel)) continue;
        ++num_seen;
        const double x = pixel->x() / size.width, y = pixel->y() / size.height;
        if (std::max(std::min(x, 1 - x), std::min(y, 1 - y)) > 0.1) continue;
        ++in_corner[2 * int{x > 0.5} + int{y > 0.5}];
      }
      EXPECT_GE(num_seen, 36) << "seed " << seed;
    }
  }
  for (const int n : in_corner) EXPECT_GE(n, 10);
}

// The fenced blocks of docs/reference/formats.md, by the name in the comment before each.
std::vector<std::pair<std::string, std::string>> documented_examples() {
  const std::string text = read_text(fs::path(TAGCAL_SOURCE_DIR) / "docs/reference/formats.md");
  const std::string mark = "<!-- example: ";
  std::vector<std::pair<std::string, std::string>> examples;
  for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + 1)) {
    const std::size_t name = at + mark.size();
    const std::size_t begin = text.find('\n', text.find("```", name)) + 1;
    examples.emplace_back(text.substr(name, text.find(" -->", name) - name),
                          text.substr(begin, text.find("```", begin) - begin));
  }
  return examples;
}

TEST_F(SceneFile, TheDocumentedExamplesAreRead) {
  int num_targets = 0;
  const auto examples = documented_examples();
  ASSERT_EQ(examples.size(), 19U);
  const std::vector<PlacedBoard> boards = {{read_target(folder_ / "target.yaml"), {}}};
  for (const auto& [name, text] : examples) {
    SCOPED_TRACE(name);
    const fs::path file = write(name, text);
    if (name == "target") {
      EXPECT_NO_THROW(read_target(file));
      ++num_targets;
    } else if (name == "observations.csv") {
      EXPECT_EQ(read_observations(file, boards)[0].observations.size(), 2U);
    } else if (name == "truth.yaml") {
      EXPECT_EQ(read_truth(file).camera_from_world.size(), 1U);
    } else if (name == "scene") {
      EXPECT_EQ(read_scene(file).num_views, 20);
    } else if (name == "scene rig") {
      const RigDataset rig =
          exact_rig_dataset(std::get<RigScene>(read_any_scene(file)), 1, nullptr);
      for (const RigCamera& camera : rig.cameras)
        for (const View& view : camera.data.views) EXPECT_FALSE(view.observations.empty());
    } else if (name.starts_with("scene ")) {
      const MovingScene scene = read_moving_scene(file);
      const Dataset dataset = exact_dataset(scene, camera_poses(scene, 1), nullptr);
      EXPECT_EQ(dataset.boards.size(), 1U);
      for (const View& view : dataset.views) EXPECT_FALSE(view.observations.empty());
    } else if (name == "calibration") {
      EXPECT_EQ(read_calibration(file).model, "opencv4");
    } else {
      ASSERT_EQ(name, "dataset");
      write("dataset.yaml", text);
      std::string csv = "image,tag_id,corner,x_px,y_px\n";
      for (int i = 0; i < 16; ++i) {
        csv += "a," + std::to_string(i / 4) + "," + std::to_string(i % 4) + ",1,1\n";
      }
      write("observations.csv", csv);
      write("truth.yaml", std::find_if(examples.begin(), examples.end(), [](const auto& e) {
                            return e.first == "truth.yaml";
                          })->second);
      EXPECT_EQ(read_dataset(folder_).dataset.views.size(), 1U);
    }
  }
  EXPECT_EQ(num_targets, 7);
}

RC_GTEST_FIXTURE_PROP(SceneFile, ManglesEndInAnErrorOrAValidScene, (std::uint64_t seed)) {
  Random random(seed);
  for (int i = 0; i < 3; ++i) {
    try {
      const Scene scene = read(mutated(kScene, random));
      for (const double p : parameters(scene.camera.lens)) RC_ASSERT(std::isfinite(p));
      RC_ASSERT(!scene.boards.empty() && scene.num_views > 0);
      RC_ASSERT(scene.sensor.exposure > 0 && scene.ink_level >= 0 && scene.ink_level <= 1);
    } catch (const Error& error) {
      RC_ASSERT(std::string(error.what()).find(folder_.string()) == 0U);
    }
  }
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
