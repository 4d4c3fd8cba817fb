#include <gtest/gtest.h>

#include "file_fixture.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/scene_file.hpp"
#include "tagcal/viewing/projection.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;

using internal::kDegree;

const std::string kBoards = "boards: [{target: {target_type: tags, tags: [{id: 0, size: 0.2}]}}]\n";
const std::string kCamera = "camera: {image_size: [640, 480], model: f, f: 500}\n";
const std::string kPath = "path: {type: look_at, eye_m: [0, -3, 1]}\n";

class SceneFrames : public FileTest {
 protected:
  MovingScene read(const std::string& text) { return read_moving_scene(write("scene.yaml", text)); }
  MovingScene with(const std::string& text) { return read(kCamera + kBoards + kPath + text); }
  Pose path(const std::string& path) {
    return camera_poses(read(kCamera + kBoards + "path: {" + path + "}\n"), 1)[0];
  }
  // The transform of frame `a` under the world in one of three views.
  Affine frame(const std::string& rest, int view = 0) {
    return frames_in_view(with("views: 3\n" + rest), view).a_from_b("world", "a");
  }
  std::string error(const std::string& text) {
    return error_about(folder_.string() + "/scene.yaml: ", [&] { read(text); });
  }
};

testing::AssertionResult agrees(const Affine& a, const Affine& b) {
  const double difference = (a.matrix() - b.matrix()).norm();
  return difference < 1e-14 ? testing::AssertionSuccess()
                            : testing::AssertionFailure() << a.matrix() << "\n\n"
                                                          << b.matrix();
}
testing::AssertionResult agrees(const Pose& a, const Pose& b) {
  return agrees(affine(a), affine(b));
}

TEST_F(SceneFrames, APoseCanBeGivenInAllWays) {
  const auto pose = [&](const std::string& text) {
    return frame("frames: [{name: a, pose: " + text + "}]\n");
  };
  const Vector3d offset(1, 2, 3);
  EXPECT_TRUE(agrees(pose("{rotation: [0, 1, 0, 0], translation_m: [1, 2, 3]}"),
                     affine(translation(offset) * rotation_about_x(180 * kDegree))));
  EXPECT_TRUE(agrees(pose("{roll_pitch_yaw_deg: [10, 20, 30], translation_m: [1, 2, 3]}"),
                     affine(translation(offset) * rotation_about_z(30 * kDegree) *
                            rotation_about_y(20 * kDegree) * rotation_about_x(10 * kDegree))));
  EXPECT_TRUE(agrees(pose("{three_points_m: [[1, 2, 3], [1, 2, 4], [2, 2, 3]]}"),
                     affine(translation(offset))));
  EXPECT_TRUE(
      agrees(pose("{axis: [0, 2, 0], angle_deg: 30}"), affine(rotation_about_y(30 * kDegree))));
  EXPECT_TRUE(agrees(pose("[[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]"),
                     affine(translation(offset))));
  EXPECT_TRUE(agrees(pose("[{translate_m: [1, 2, 3]}, {rotate_x_deg: 10}, {scale: 2}, "
                          "{rotate_deg: 90, axis: [0, 0, 1], point_m: [1, 0, 0]}]"),
                     translation(offset) * rotation_about_x(10 * kDegree) * scaling(2) *
                         rotation_about_line({1, 0, 0}, {0, 0, 1}, 90 * kDegree)));
  EXPECT_TRUE(
      agrees(pose("{look_at: {eye_m: [3, 0, 0], target_m: [0, 0, 1], up: [0, 1, 0]}}"),
             affine(camera_from_world_looking_at({3, 0, 0}, {0, 0, 1}, {0, 1, 0}).inverse())));
  const Aircraft plane{{5, 60 * kDegree, 30 * kDegree}, 0.0, 0.0, 10 * kDegree};
  EXPECT_TRUE(agrees(pose("{aircraft: {rho_m: 5, theta_deg: 60, phi_deg: 30, roll_deg: 10}}"),
                     affine(world_from_aircraft(plane))));
}

TEST_F(SceneFrames, AChildHangsOnItsParentInAnyOrder) {
  EXPECT_TRUE(agrees(frame("frames:\n  - {name: a, parent: b, pose: {translation_m: [0, 0, 1]}}\n"
                           "  - {name: b, pose: {axis: [1, 0, 0], angle_deg: 90}, scale: 2}\n"),
                     rotation_about_x(90 * kDegree) * scaling(2) * translation({0, 0, 1})));
}

TEST_F(SceneFrames, MotionRunsEvenlyOverTheViewsInTheFrameItself) {
  const std::string text =
      "frames: [{name: a, pose: {translation_m: [0, 1, 0]}, scale: 3}]\n"
      "motion: [{frame: a, steps: [{rotate_z_deg: [0, 90]}, "
      "{translate_m: [[0, 0, 0], [1, 0, 0], [1, 0, 4]]}]}]\n";
  EXPECT_TRUE(agrees(frame(text, 0), translation({0, 1, 0}) * scaling(3)));
  EXPECT_TRUE(agrees(frame(text, 1), translation({0, 1, 0}) * scaling(3) *
                                         rotation_about_z(45 * kDegree) * translation({1, 0, 0})));
  EXPECT_TRUE(agrees(frame(text, 2), translation({0, 1, 0}) * scaling(3) *
                                         rotation_about_z(90 * kDegree) * translation({1, 0, 4})));
}

TEST_F(SceneFrames, EveryCameraOfTheLectures) {
  EXPECT_TRUE(agrees(path("type: look_at, eye_m: [1, 2, 3], target_m: [0, 0, 1], up: [0, 1, 0]"),
                     camera_from_world_looking_at({1, 2, 3}, {0, 0, 1}, {0, 1, 0})));
  EXPECT_TRUE(
      agrees(path("type: orbit, target_m: [0, 0, 1], distance_m: 4, azimuth_deg: 30, "
                  "elevation_deg: 90, twist_deg: 5"),
             camera_from_world_on_orbit({{0, 0, 1}, 4, 30 * kDegree, 90 * kDegree, 5 * kDegree})));
  EXPECT_TRUE(
      agrees(path("type: aircraft, rho_m: 5, theta_deg: 60, phi_deg: 30, yaw_deg: 10, "
                  "pitch_deg: 20, roll_deg: 40"),
             camera_from_world_in_aircraft(
                 {{5, 60 * kDegree, 30 * kDegree}, 10 * kDegree, 20 * kDegree, 40 * kDegree})));
  EXPECT_TRUE(
      agrees(path("type: roll_pitch_yaw, centre_m: [1, 2, 3], roll_deg: 10, pitch_deg: 20, "
                  "yaw_deg: 30"),
             camera_from_world_with_angles({10 * kDegree, 20 * kDegree, 30 * kDegree}, {1, 2, 3})));
  EXPECT_TRUE(
      agrees(path("type: drawn, view: plan, target_m: [1, 2, 3], distance_m: 7"),
             translation({0, 0, 7}) * Pose(camera_from_world_drawn(DrawnView::plan), {0, 0, 0}) *
                 translation({-1, -2, -3})));
}

TEST_F(SceneFrames, AnAircraftCarriesItsCamera) {
  const MovingScene scene =
      read(kCamera + kBoards +
           "frames: [{name: plane, pose: {aircraft: {rho_m: 5, theta_deg: 60, yaw_deg: 10}}}]\n"
           "path: {type: frame, frame: plane}\n");
  EXPECT_TRUE(agrees(camera_poses(scene, 1)[0],
                     world_from_aircraft({{5, 60 * kDegree, 0}, 10 * kDegree, 0, 0}).inverse()));
}

TEST_F(SceneFrames, ParallelCameras) {
  const auto lens = [&](const std::string& camera) {
    const auto text = "camera: {image_size: [640, 480], model: parallel, scale_px_per_m: 100" +
                      camera + "}\n" + kBoards + "path: {type: drawn, view: front_elevation}\n";
    const Lens read_lens = read(text).settings.camera.lens;  // parameters() points into it
    const auto p = parameters(read_lens);
    return std::vector<double>(p.begin(), p.end());
  };
  const double half = std::sqrt(0.5);
  EXPECT_EQ(lens(""), (std::vector<double>{100, 100, 319.5, 239.5, 0, 0}));
  EXPECT_NEAR(lens(", projection: cavalier")[4], half, 1e-15);
  EXPECT_NEAR(lens(", projection: cavalier")[5], -half, 1e-15);  // up in the picture
  EXPECT_NEAR(lens(", projection: cabinet, recedes_deg: 30")[4], std::sqrt(3) / 4, 1e-15);
  EXPECT_EQ(lens(", projection: oblique, direction: [1, 0, -2]")[4], 0.5);
}

TEST_F(SceneFrames, FieldOfViewByHeightAndDiagonalAndASectorOfAWall) {
  const auto camera = [&](const std::string& text) {
    return read("camera: {image_size: [640, 480], model: f, " + text + "}\n" + kBoards + kPath)
        .settings;
  };
  const Scene by_height = camera("field_of_view_height_deg: 90");
  EXPECT_NEAR(parameters(by_height.camera.lens)[0], 240, 1e-12);
  const Scene by_diagonal = camera("field_of_view_diagonal_deg: 90");
  EXPECT_NEAR(parameters(by_diagonal.camera.lens)[0], 400, 1e-12);
  const Scene scene = camera("f: 500, sector: {columns: 3, rows: 2, column: 2, row: 1}");
  EXPECT_EQ(scene.camera.image_size, (ImageSize{214, 240}));
  EXPECT_EQ(parameters(scene.camera.lens)[2], 319.5 - 426);
  EXPECT_EQ(scene.model, "f+c");
}

TEST_F(SceneFrames, BinnedAndResizedPicturesHaveTheSmallestModelThatContainsThem) {
  const auto camera = [&](const std::string& text) {
    return read("camera: {image_size: [640, 480], " + text + "}\n" + kBoards + kPath).settings;
  };
  const Scene binned = camera("model: f, f: 500, binned: [2, 2]");
  EXPECT_EQ(binned.camera.image_size, (ImageSize{320, 240}));
  EXPECT_EQ(parameters(binned.camera.lens)[0], 250);
  EXPECT_EQ(parameters(binned.camera.lens)[2], 159.5);
  EXPECT_EQ(binned.model, "f");
  EXPECT_EQ(camera("model: f, f: 500, binned: [2, 1]").model, "pinhole");
  EXPECT_EQ(camera("model: f, f: 500, binned: [3, 3]").model, "f+c");  // a column is lost
  EXPECT_EQ(camera("model: radial1, f: 500, distortion: [-0.1], binned: [1, 2]").model, "opencv4");
  EXPECT_EQ(camera("model: fisheye4, f: 200, binned: [1, 2]").model, "fisheye4");
  const Scene both = camera(
      "model: f, f: 500, sector: {columns: 2, rows: 2, column: 1, row: 1}, binned: [2, 2], "
      "resized: [640, 480]");
  EXPECT_EQ(both.camera.image_size, (ImageSize{640, 480}));
  EXPECT_NEAR(parameters(both.camera.lens)[0], 1000, 1e-12);
  EXPECT_NEAR(parameters(both.camera.lens)[2], -0.5, 1e-12);
  EXPECT_EQ(both.model, "f+c");
}

TEST_F(SceneFrames, FacesOfACuboidHaveItsName) {
  const MovingScene scene = with(
      "occluders: [{corners: [[1, 0, 0], [2, 0, 0], [2, 1, 0]]}]\n"
      "cuboids: [{size_m: [1, 1, 1]}, {size_m: [1, 1, 1]}]\n");
  ASSERT_EQ(scene.occluders.size(), 13U);
  EXPECT_EQ(scene.occluders[0].occluder.name, "");
  EXPECT_EQ(scene.occluders[1].occluder.name, "cuboid 0");
  EXPECT_EQ(scene.occluders[12].occluder.name, "cuboid 1");
}

TEST_F(SceneFrames, TheTruthKeepsAllFrames) {
  const std::string long_name(3000, 'd');  // longer than YAML's plain keys
  const MovingScene scene =
      with("views: 2\nframes: [{name: a, scale: 2}, {name: 'b c', parent: a}, {name: " + long_name +
           "}]\nmotion: [{frame: a, steps: [{rotate_z_deg: [0, 90]}]}]\n");
  const Truth truth = *exact_dataset(scene, camera_poses(scene, 1), nullptr).truth;
  write_truth(folder_ / "truth.yaml", truth);
  const Truth back = read_truth(folder_ / "truth.yaml");
  ASSERT_EQ(back.hierarchy.size(), 2U);
  for (const auto& [image, hierarchy] : truth.hierarchy) {
    ASSERT_EQ(hierarchy.camera_from_frame.size(), 4U);
    for (const auto& [name, transform] : hierarchy.camera_from_frame)
      EXPECT_TRUE(agrees(back.hierarchy.at(image).camera_from_frame.at(name), transform)) << name;
    EXPECT_TRUE(agrees(back.hierarchy.at(image).camera_from_board.at(0),
                       hierarchy.camera_from_board.at(0)));
  }
}

TEST_F(SceneFrames, TheTruthOfAParallelCameraIsItsMatrix) {
  const Truth truth{{Parallel({100, 110, 319.5, 239.5, 0.25, -0.5}), {640, 480}},
                    kParallelModel,
                    {{"000.png", Pose()}},
                    {},
                    {}};
  write_truth(folder_ / "truth.yaml", truth);
  EXPECT_HAS(read_text(folder_ / "truth.yaml"),
             "image_from_camera: [[100, 0, 25, 319.5], [0, 110, -55, 239.5]]");
  const Truth back = read_truth(folder_ / "truth.yaml");
  EXPECT_EQ(back.model, kParallelModel);
  EXPECT_EQ(std::get<Parallel>(back.camera.lens).parameters(),
            std::get<Parallel>(truth.camera.lens).parameters());
}

TEST_F(SceneFrames, WhatMovesIsNoStillScene) {
  const auto file =
      write("scene.yaml", kCamera + kBoards + kPath +
                              "views: 2\nframes: [{name: a}]\n"
                              "motion: [{frame: a, steps: [{rotate_x_deg: [0, 1]}]}]\n");
  EXPECT_THROW(read_scene(file), Error);
}

TEST_F(SceneFrames, BadFramesAndViews) {
  const std::string base = kCamera + kBoards + kPath;
  const std::vector<std::pair<std::string, std::string>> table = {
      {base + "frames: [{name: a, parent: b}, {name: b, parent: a}]\n", "frames: '"},
      {base + "frames: [{name: a, parent: b}]\n", "frames: 'b'"},
      {base + "frames: [{name: a}, {name: a}]\n", "frames: 'a' is there twice"},
      {base + "frames: [{name: world}]\n", "frames: 'world' is there twice"},
      {base + "frames: [{name: a, scale: 0}]\n", "frames[0].scale: must not be zero, got 0"},
      {base + "frames: [{name: a, scale: [1, 2]}]\n", "frames[0].scale: must be a list of"},
      {base + "frames: [{name: a, pose: {axis: [0, 0, 0], angle_deg: 3}}]\n",
       "frames[0].pose.axis: must not be zero"},
      {base + "frames: [{name: a, pose: {look_at: {eye_m: [0, 0, 1]}}}]\n",
       "frames[0].pose.look_at: look-at: up is parallel to the view"},
      {base + "frames: [{name: a, pose: [{rotate_x_deg: [0, 90]}]}]\n",
       "frames[0].pose[0]: changes over the views: that belongs under motion"},
      {base + "frames: [{name: a, pose: [{rotate_x_deg: 1, translate_m: [0, 0, 0]}]}]\n",
       "frames[0].pose[0]: must be one step"},
      {base + "motion: [{frame: a, steps: [{rotate_x_deg: 1}]}]\n",
       "motion[0].frame: must be the name of one of the frames, got a"},
      {base + "frames: [{name: a}]\nmotion: [{frame: a, steps: []}]\n",
       "motion[0].steps: must be a list of at least 1"},
      {base + "cuboids: [{size_m: [1, 0, 1]}]\n", "cuboids[0].size_m[1]: must be > 0, got 0"},
      {base + "cuboids: [{size_m: [1, 1, 1], frame: a}]\n",
       "cuboids[0].frame: must be world or the name of one of the frames, got a"},
      {kCamera + kPath + "frames: [{name: a, scale: 2}]\n" +
           replaced(kBoards, "[{target", "[{frame: a, target"),
       "scene: boards[0] hangs on frame 'a', which scales or shears, but must be rigid"},
      {kCamera + kPath + replaced(kBoards, "[{target", "[{pose: [{scale: 2}], target"),
       "boards[0].pose: must be rigid: without a scale"},
      {kCamera + kPath +
           replaced(kBoards, "[{target", "[{frame: world, world_from_board: {}, target"),
       "boards[0].world_from_board: belongs to a board without frame and pose"},
      {kCamera + kBoards + "path: {type: look_at, eye_m: [0, 0, 1]}\n",
       "path: look-at: up is parallel to the view"},
      {kCamera + kBoards + "path: {type: orbit, distance_m: 0}\n", "path: orbit: distance: must"},
      {kCamera + kBoards + "path: {type: drawn, view: below}\n", "path.view: must be plan, front_"},
      {kCamera + kBoards + "path: {type: frame, frame: a}\n", "path.frame: must be world or the"},
      {kCamera + kBoards +
           "path: {type: window, lower_left_m: [0, 0, 0], lower_right_m: [1, 0, 0], "
           "upper_left_m: [0, 0, 1], eye_m: [0, 1, 0]}\n",
       "path: window: the eye must be before it"},
      {"camera: {image_size: [640, 480], model: window}\n" + kBoards + kPath,
       "path: type window and the camera's model window need each other"},
      {replaced(kCamera, "f: 500", "f: 500, field_of_view_height_deg: 50") + kBoards + kPath,
       "camera: needs one of f, fx and fy, field_of_view_deg"},
      {replaced(kCamera, "f: 500", "f: 500, binned: [2, 0]") + kBoards + kPath,
       "camera.binned[1]: must be a whole number from 1 to 480, got 0"},
      {base + "frames: [{name: a, pose: {three_points_m: [[0, 0, 0], [1, 1, 1], [2, 2, 2]]}}]\n",
       "frames[0].pose.three_points_m: must not lie on a line"},
      {replaced(kCamera, "f: 500", "f: 500, sector: {columns: 3, rows: 2, column: 3, row: 1}") +
           kBoards + kPath,
       "camera.sector.column: must be a whole number from 0 to 2, got 3"},
      {"camera: {image_size: [640, 480], model: parallel, scale_px_per_m: 100, projection: "
       "oblique, "
       "direction: [1, 0, 0]}\n" +
           kBoards + kPath,
       "camera.direction: must leave the plane of projection"},
      {"camera: {image_size: [640, 480], model: parallel, scale_px_per_m: 100, recedes_deg: 3}\n" +
           kBoards + kPath,
       "camera.recedes_deg: belongs to cavalier and cabinet only"}};
  EXPECT_NO_THROW(read(base));
  for (const auto& [text, expected] : table) expect_line(error(text), expected);
}

}  // namespace
}  // namespace tagcal
