#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <numbers>

#include "scene_file_fixture.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/target_file.hpp"

namespace tagcal {
namespace {

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
  EXPECT_HAS(warnings_[0], "target.yaml: colour: unknown key");
  EXPECT_EQ(error(replaced(kScene, "target_type: tags, tags: [{id: 9, size: 0.2}]",
                           "target_type: aprilgrid, tagCols: 1, tagRows: 1, tagSize: 1, "
                           "tagSpacing: 0, colour: red"))
                .substr(0, 53),
            "scene.yaml: boards[1].target.colour: unknown key; kno");
}

TEST_F(SceneFile, FilesOfAnotherKindAreNamed) {
  EXPECT_EQ(error("target_type: aprilgrid\n"), "scene.yaml: is a target file, not a scene");
  EXPECT_EQ(error("image_size: [4, 3]\nimages: []\n"), "scene.yaml: is a data set, not a scene");
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
  for (const BadFile& bad : table)
    expect_line(error(replaced(kScene, bad.from, bad.to)), bad.message);
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

}  // namespace
}  // namespace tagcal
