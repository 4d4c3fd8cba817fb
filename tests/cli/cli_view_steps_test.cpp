// tagcal view --steps and --opengl, and its inputs beside scenes.
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"
#include "view_json.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

const std::string kSources = TAGCAL_SOURCE_DIR;

// The steps of a seen corner of the scene's board, as JSON, beside the whole answer.
struct Steps {
  Json answer;
  const Json& operator[](const char* name) const { return answer["steps"][name]; }
};

TEST_F(Cli, TheStepsOfDepthLeadBack) {
  const Outcome outcome = run("view " + path("scene.yaml") + " --at 5:3 --near 0.2 --far 2 --json");
  const Steps steps{Json::parse(outcome.out)};
  const double z = steps.answer["point"]["in_eye_m"][2], n = 0.2, f = 2;
  const Json& depth = steps["depth"];
  EXPECT_NEAR(depth["z_back_from_opengl_m"], z, 1e-12);
  EXPECT_NEAR(depth["z_back_from_phigs_m"], z, 1e-12);
  EXPECT_NEAR(depth["opengl"], steps.answer["point"]["in_ndc"][2], 1e-12);
  EXPECT_NEAR(depth["zero_to_one"], f * (z + n) / (z * (f - n)), 1e-12);
  EXPECT_NEAR(depth["one_to_zero"], 1 - f * (z + n) / (z * (f - n)), 1e-12);
  EXPECT_NEAR(depth["phigs"], -f * (z + n) / (z * (f - n)), 1e-12);
  EXPECT_NEAR(depth["resolution_16_bits_m"], z * z * (f - n) / (f * n) / 65535, 1e-12);
  // The steps that PHIGS and OpenGL share, and the last of OpenGL, make OpenGL's matrix.
  Eigen::Matrix4d product = Eigen::Matrix4d::Identity();
  for (const Json& step : steps["normalising_steps"]["opengl"])
    if (!step["name"].get<std::string>().starts_with("product"))
      product = matrix(step["matrix"]) * product;
  const Eigen::Matrix4d clip = matrix(steps.answer["matrices"]["clip_from_eye"]);
  EXPECT_LT((product * clip(3, 2) / product(3, 2) - clip).norm(), 1e-12);
  EXPECT_EQ(steps["planes"]["inside_all"], true);
  EXPECT_NEAR(steps["planes"]["inside_far_m"], f + z, 1e-12);
  EXPECT_EQ(steps["line_clip"]["outcode_top_bottom_right_left"], "0000");
}

TEST_F(Cli, TheStepsOfTheBoardsPlaneAgreeWithItsImage) {
  spill(root() / "pinhole.yaml",
        replaced(kScene, "model: radial1, f: 520, cx: 317, cy: 203, distortion: [-0.1]",
                 "model: f+c, f: 520, cx: 317, cy: 203"));
  const Outcome outcome = run("view " + path("pinhole.yaml") + " --view 1 --at 5:3 --json");
  const Steps steps{Json::parse(outcome.out)};
  const Json& plane = steps["plane_of_board"];
  const Eigen::VectorXd point = vector(steps.answer["point"]["in_board_m"]);
  EXPECT_NEAR(plane["line_of_sight"]["u_m"], point.x(), 1e-9);
  EXPECT_NEAR(plane["line_of_sight"]["v_m"], point.y(), 1e-9);
  EXPECT_NEAR(plane["line_of_sight"]["t_m"], vector(steps.answer["point"]["in_camera_m"]).norm(),
              1e-9);
  EXPECT_EQ(plane["side_seen"], "front");
  EXPECT_EQ(plane["plane_in_world"], Json({0, 0, 1, 0}));  // its normal points out of the front
  const Eigen::VectorXd flattened = vector(plane["flattened"]["plane_after_it"]);
  EXPECT_NEAR(std::abs(flattened[2]), 1, 1e-12);
  EXPECT_NEAR(flattened[3] / flattened[2], -1, 1e-12);
  Eigen::Matrix3d h;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) h(r, c) = plane["raster_from_board"][r][c];
  // The board lies in the world's xy-plane: its horizon has the vanishing points of x and y.
  const Eigen::Vector3d horizon = vector(plane["horizon"]["line_abc"]);
  for (const char* name : {"x_px", "y_px"}) {
    const Eigen::VectorXd vanishing = vector(steps["vanishing_points"][name]);
    EXPECT_NEAR(horizon.head<2>().dot(vanishing) + horizon.z(), 0, 1e-6) << name;
  }
  EXPECT_EQ(steps["vanishing_points"]["kind"], "three-point perspective");
  const Eigen::VectorXd conic = vector(plane["circle"]["conic_abcdef"]);
  for (double angle = 0; angle < 6; angle += 1) {
    const Eigen::Vector2d p = (h * Eigen::Vector3d(point.x() + 0.1 * std::cos(angle),
                                                   point.y() + 0.1 * std::sin(angle), 1))
                                  .hnormalized();
    Eigen::Matrix<double, 6, 1> terms;
    terms << p.x() * p.x(), p.x() * p.y(), p.y() * p.y(), p.x(), p.y(), 1;
    EXPECT_LT(std::abs(conic.dot(terms)), 1e-9 * std::abs(conic[5])) << angle;
  }
}

TEST_F(Cli, TheStepsPlaceTheCamera) {
  const std::string path_key =
      "path: {type: dome, target_m: [0.14, 0.1, 0], min_distance_m: 0.45, "
      "max_distance_m: 0.6, min_elevation_deg: 45, max_elevation_deg: 80}";
  std::string scene =
      replaced(kScene, path_key,
               "frames:\n  - {name: a, pose: {translation_m: [1, 2, 3]}}\n  - {name: "
               "b, parent: a, pose: [{rotate_z_deg: 90}]}\npath: {type: orbit, "
               "distance_m: 0.5, azimuth_deg: 40, elevation_deg: 30, frame: b}");
  scene = replaced(scene, "jitter: {target_m: 0.02, roll_deg: 20}\n", "");
  scene = replaced(scene, "corner_squares: false}\n", "corner_squares: false}\n    frame: b\n");
  spill(root() / "hung.yaml", scene);
  const Outcome outcome = good_run("view " + path("hung.yaml") + " --at 0:0 --json");
  const Steps steps{Json::parse(outcome.out)};
  EXPECT_NEAR(steps["orbit"]["azimuth_deg"], 130, 1e-9);
  EXPECT_NEAR(steps["orbit"]["elevation_deg"], 30, 1e-9);
  EXPECT_LT((vector(steps["look_at"]["eye_m"]) -
             Eigen::Vector3d(1 - 0.5 * std::sin(40 * M_PI / 180) * std::cos(M_PI / 6),
                             2 + 0.5 * std::cos(40 * M_PI / 180) * std::cos(M_PI / 6), 3.25))
                .norm(),
            1e-12);
  EXPECT_NEAR(steps["roll_pitch_yaw"]["yaw_deg"], -50, 1e-9);
  EXPECT_NEAR(steps["roll_pitch_yaw"]["pitch_deg"], 30, 1e-9);
  const Json& chain = steps["frames_of_board"];
  ASSERT_EQ(chain.size(), 3U);
  EXPECT_EQ(chain[0]["name"], "a");
  EXPECT_EQ(chain[2]["name"], "board 0");
  Eigen::Matrix4d product = Eigen::Matrix4d::Identity();
  for (const Json& frame : chain) {
    product *= matrix(frame["parent_from_frame"]);
    EXPECT_LT((product - matrix(frame["world_from_frame"])).norm(), 1e-12) << frame["name"];
  }
  const std::string text = run("view " + path("hung.yaml") + " --at 0:0 --steps").out;
  for (const char* part : {"frames_of_board", "phigs", "three-point", "aircraft"})
    EXPECT_HAS(text, part);
  EXPECT_LACKS(text, "gimbal lock");
  EXPECT_LACKS(text, "-0.000000");
  spill(root() / "down.yaml", replaced(scene, "elevation_deg: 30", "elevation_deg: 90"));
  const std::string down = run("view " + path("down.yaml") + " --at 0:0 --steps").out;
  EXPECT_HAS(down, "gimbal lock");
}

TEST_F(Cli, TheStepsFindTheMatricesFromMatchedCornersAndByThreeMoves) {
  for (const char* name : {"wall", "window", "house"}) {  // off-centre, and oblique
    const Outcome outcome = good_run("view " + kSources + "/data-synthetic/scenes/viewing/" + name +
                                     ".yaml --near 0.3 --far 3 --json");
    const Steps steps{Json::parse(outcome.out)};
    const Json& matched = steps["five_matched_corners"];
    const Eigen::Matrix4d clip = matrix(steps.answer["matrices"]["clip_from_eye"]);
    EXPECT_LT((matrix(matched["clip_from_eye, scaled to w = -z (parallel: 1)"]) - clip).norm(),
              1e-12)
        << name;
    Eigen::Matrix3d product = Eigen::Matrix3d::Identity(), whole;
    const auto moves = nlohmann::ordered_json::parse(outcome.out)["steps"]["window_to_viewport"];
    for (const auto& [step, rows] : moves.items()) {
      Eigen::Matrix3d m;
      for (int i = 0; i < 9; ++i) m(i / 3, i % 3) = rows[i / 3][i % 3];
      if (step == "product")
        whole = m;
      else
        product = (m * product).eval();
    }
    EXPECT_LT((product - whole).norm(), 1e-9) << name;
  }
}

TEST_F(Cli, ViewClipsALineByCodesByItsParameterAndInSpace) {
  const std::string doorway =
      "view " + kSources + "/data-synthetic/scenes/doorway.yaml --near 1 --far 10 ";
  const auto line = [&](const std::string& points) {
    const Outcome outcome = good_run(doorway + points + " --json");
    return Json::parse(outcome.out)["steps"]["line_to"];
  };
  const Json cut = line("--at -5.76,3,-0.08 --to 2.88,3,3.16");  // the course's line
  EXPECT_EQ(cut["codes_top_bottom_right_left"], "0001 1010");
  EXPECT_EQ(cut["codes_or"], "1011");
  EXPECT_EQ(cut["codes_say"], "cut at a border, and test again");
  EXPECT_LT((vector(cut["by_codes_in_ndc"][0]) - Eigen::Vector2d(-1, 0.25)).norm(), 1e-12);
  EXPECT_LT((vector(cut["by_codes_in_ndc"][1]) - Eigen::Vector2d(0.5, 1)).norm(), 1e-12);
  for (const char* t : {"by_parameter_t", "in_space_by_six_planes_t"})
    EXPECT_LT((vector(cut[t]) - Eigen::Vector2d(4.0 / 9, 7.0 / 9)).norm(), 1e-12) << t;
  const Json beyond = line("--at -5.76,3,-0.08 --to -5.76,3,3.16");
  EXPECT_EQ(beyond["codes_and"], "0001");
  EXPECT_EQ(beyond["codes_say"], "all outside, beyond one border");
  EXPECT_EQ(beyond["by_codes_in_ndc"], nullptr);
  EXPECT_EQ(line("--at 0:2 --to 0:0")["codes_say"], "all inside");
  const Json behind = line("--at 0,4,1 --to 0,-4,1");  // through the eye: near is 3/8 of the way
  EXPECT_EQ(behind["image"], "an end is behind the eye: the line is cut in space first");
  EXPECT_LT((vector(behind["in_space_by_six_planes_t"]) - Eigen::Vector2d(0, 0.375)).norm(), 1e-12);
  expect_bad_input(doorway + "--to 99:0", {"--to", "99:0"});
  expect_bad_input(doorway + "--to 0:0 --svg", {"--to", "--svg"});
}

// The relation that docs/course/viewing.md states between the two kinds of angles.
TEST_F(Cli, TheStepsTurnACameraOfGraphics) {
  const std::string scene = slurp(kSources + "/data-synthetic/scenes/viewing/turned.yaml");
  spill(root() / "rolled.yaml", scene.substr(0, scene.find("path: ")) +
                                    "path: {type: roll_pitch_yaw, centre_m: [0, 0, 0.6], roll_deg: "
                                    "10, pitch_deg: 37, yaw_deg: 53}\n");
  const Outcome outcome = good_run("view " + path("rolled.yaml") + " --json");
  const Steps steps{Json::parse(outcome.out)};
  const Json& turns = steps["eye_turns_in_a_world_with_y_up"];
  EXPECT_NEAR(turns["about_z_deg"], 10, 1e-9);
  EXPECT_NEAR(turns["about_x_deg"], 37, 1e-9);
  EXPECT_NEAR(turns["about_y_deg"], 90 - 53, 1e-9);
}

TEST_F(Cli, ViewSaysWhyACameraSeesWhatARendererDoesNotDraw) {
  const std::string doorway = "view " + kSources + "/data-synthetic/scenes/doorway.yaml --at 0:2 ";
  const std::string far = run(doorway + "--near 1 --far 3").out;
  EXPECT_HAS(far, "outside the volume: beyond far");
  EXPECT_HAS(far, "only a renderer has near and far planes");
  const std::string inside = run(doorway + "--near 1 --far 10").out;
  EXPECT_LACKS(inside, "only a renderer");
  EXPECT_LACKS(inside, "-0.000000");
}

TEST_F(Cli, ViewOfACalibrationAndOfADataSet) {
  spill(root() / "camera.yaml", kCamera);
  const Json camera = Json::parse(run("view " + path("camera.yaml") + " --json").out);
  const Eigen::VectorXd columns = vector(camera["opengl"]["projection"]);
  EXPECT_EQ(Eigen::Matrix4d(Eigen::Map<const Eigen::Matrix4d>(columns.data())),
            matrix(camera["matrices"]["clip_from_eye"]));
  EXPECT_NEAR(camera["opengl"]["camera_from_projection"]["fx"], 902.5, 1e-9);
  EXPECT_NEAR(camera["opengl"]["camera_from_projection"]["cy"], 391.7, 1e-9);
  const std::string snippet = run("view " + path("camera.yaml") + " --opengl").out;
  for (const char* part : {"glLoadMatrixd(projection)", "has distortion", "glViewport(0, 0, 1280"})
    EXPECT_HAS(snippet, part);
  // The truth's pose and that of the exact corners through the truth's camera agree.
  const Json scene = Json::parse(run("view " + path("scene.yaml") + " --view 3 --json").out);
  const Json truth = Json::parse(run("view " + path("set") + " --view 3 --json").out);
  EXPECT_EQ(truth["point"]["pixel"], scene["point"]["pixel"]);
  spill(root() / "own.yaml", R"(image_width: 640
image_height: 400
camera_matrix: {rows: 3, cols: 3, dt: d, data: [520, 0, 317, 0, 520, 203, 0, 0, 1]}
distortion_coefficients: {rows: 1, cols: 5, dt: d, data: [-0.1, 0, 0, 0, 0]}
)");
  const Outcome estimated = good_run("view " + exact_set("exact").string() +
                                     " --view 3 --json --camera " + path("own.yaml"));
  EXPECT_LT((vector(Json::parse(estimated.out)["point"]["pixel"]) - vector(scene["point"]["pixel"]))
                .norm(),
            1e-3);
}

}  // namespace
}  // namespace tagcal::tools
