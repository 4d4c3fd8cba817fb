// tagcal reproject --rectify and tagcal triangulate, from outside.
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "cli_fixture.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/rig_calibration_file.hpp"
#include "tagcal/reproject/rectify.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

constexpr const char* kRigScene = R"(
rig:
  cameras:
    - {name: left, camera: {image_size: [480, 360], model: radial1, f: 400, distortion: [-0.1]}}
    - name: right
      camera: {image_size: [480, 360], model: radial1, f: 405, distortion: [-0.08]}
      rig_from_camera: {translation_m: [0.08, 0.002, 0.001], roll_pitch_yaw_deg: [1, 2, 3]}
boards:
  - target: {target_type: aprilgrid, tagCols: 4, tagRows: 4, tagSize: 0.08, tagSpacing: 0.3}
    world_from_board: {translation_m: [-0.2, -0.2, 0]}
path: {type: dome, min_distance_m: 0.6, max_distance_m: 0.9, min_elevation_deg: 50}
jitter: {target_m: 0.05, roll_deg: 180}
views: 8
sensor: {blur_px: 0.6, noise_levels: 2}
)";

class CliRectify : public Cli {
 protected:
  static void SetUpTestSuite() {
    Cli::SetUpTestSuite();
    spill(root() / "rig-scene.yaml", kRigScene);
    ASSERT_EQ(run("render " + path("rig-scene.yaml") + " --out " + path("rig")).exit_code, 0);
    const Outcome rig = run("rig " + path("rig") + " --out " + path("rig.yaml"));
    ASSERT_EQ(rig.exit_code, 0) << rig.err << rig.out;
  }

  // Of the folders, or of one picture each.
  static std::string pair(const std::string& rest, const std::string& picture = "") {
    return "reproject " + path("rig/left/images" + picture) + " " +
           path("rig/right/images" + picture) + " --camera " + path("rig.yaml") + " " + rest;
  }
  static KnownRig rig() { return known_rig(read_camera_file(root() / "rig.yaml"), "rig.yaml"); }
};

TEST_F(CliRectify, TwoFoldersBecomeRectifiedPairs) {
  const Outcome done = good_run(pair("--rectify " + path("flat") + " --alpha 0.5 --maps --target " +
                                     path("rig/target.yaml")));
  EXPECT_HAS(done.err, "8 pairs of left and right, rectified.yaml");
  // The disparity of the corners is what the claims say.
  std::smatch found;
  const std::regex sentence(R"(vertical disparity of (\d+) corners in 8 pairs: rms (\S+) px, )"
                            R"(expected (\S+) px)");
  ASSERT_TRUE(std::regex_search(done.out, found, sentence)) << done.out;
  EXPECT_GT(std::stoi(found[1]), 400);
  EXPECT_LT(std::stod(found[2]), 0.2);
  EXPECT_NEAR(std::stod(found[2]) / std::stod(found[3]), 1, 0.5);

  // OpenCV reads the file, and has the library's numbers.
  const RectifiedPair rectified = rectify(rig(), 0, 1, {0.5, true, false});
  cv::FileStorage file(path("flat/rectified.yaml"), cv::FileStorage::READ);
  ASSERT_TRUE(file.isOpened());
  for (std::size_t k = 0; k < 2; ++k) {
    cv::Mat r, p;
    file["R" + std::to_string(k + 1)] >> r;
    file["P" + std::to_string(k + 1)] >> p;
    ASSERT_EQ(r.size(), cv::Size(3, 3));
    ASSERT_EQ(p.size(), cv::Size(4, 3));
    const ProjectionMatrix expected = projection_matrix(rectified, k);
    const Eigen::Matrix3d turn = rectified.camera_from_rectified[k].rotation_matrix().transpose();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 4; ++j) {
        EXPECT_NEAR(p.at<double>(i, j), expected(i, j), 1e-9);
        if (j < 3) {
          EXPECT_NEAR(r.at<double>(i, j), turn(i, j), 1e-12);
        }
      }
  }
  cv::Mat q;
  file["Q"] >> q;
  EXPECT_NEAR(q.at<double>(3, 2), disparity_to_depth(rectified)(3, 2), 1e-9);

  // Pictures, their camera, maps, and a picture of both with lines.
  for (const std::string camera : {"left", "right"}) {
    EXPECT_EQ(read_image(root() / "flat" / camera / "000.png").size(), (ImageSize{480, 360}));
    EXPECT_EQ(read_calibration(root() / "flat" / camera / "camera.yaml").camera.image_size,
              (ImageSize{480, 360}));
    EXPECT_HAS(slurp(root() / "flat" / camera / "map.npy"), "'shape': (360, 480, 2)");
  }
  EXPECT_EQ(read_image(root() / "flat/lines/000.png").size(), (ImageSize{960, 360}));
  EXPECT_EQ(fs::exists(root() / "flat/lines/001.png"), true);

  expect_bad_input(pair("--rectify " + path("flat")), {"rectified.yaml: exists", "--force"});
  EXPECT_EQ(run(pair("--force --rectify " + path("flat"))).exit_code, 0);
}

TEST_F(CliRectify, OnePairAndPanoramas) {
  good_run(pair("--longlat --rectify " + path("round"), "/003.png"));
  EXPECT_HAS(slurp(root() / "round/rectified.yaml"), "panorama: transverse");
  EXPECT_TRUE(fs::exists(root() / "round/right/003.png"));
  EXPECT_TRUE(fs::exists(root() / "round/left/panorama.yaml"));
  // Exchanged cameras: by name, and by option.
  const Outcome other =
      good_run("reproject " + path("rig/right/images") + " " + path("rig/left/images") +
               " --camera " + path("rig.yaml") + " --rectify " + path("other"));
  EXPECT_HAS(other.err, "left is left of right: disparities are negative");
  // Maps need no pictures.
  good_run("reproject --camera " + path("rig.yaml") + " --cameras left,right --maps --rectify " +
           path("maps"));
  EXPECT_TRUE(fs::exists(root() / "maps/left/map.npy"));
}

TEST_F(CliRectify, BadInputIsOneLineAndNothingIsWritten) {
  const std::string to = "--rectify " + path("no");
  const std::vector<std::string> before = names();
  for (const std::string alpha : {"-0.1", "1.5", "x"})
    expect_bad_input(pair(to + " --alpha=" + alpha), {"--alpha: must be", alpha});
  expect_bad_input(pair(to + " --alpha 0.5 --longlat"), {"--alpha: not with --longlat"});
  expect_bad_input(
      "reproject " + path("rig/left/images") + " --camera " + path("rig.yaml") + " " + to,
      {"needs the pictures of two cameras", "got 1"});
  expect_bad_input(pair(to + " --cameras left,middle"), {"has no camera middle, only left, right"});
  expect_bad_input(pair(to + " --cameras left,left"), {"needs two cameras, got left twice"});
  expect_bad_input(pair(to + " --undistort all"), {"only one of them"});
  expect_bad_input(pair(to + " --tiles 5x5"), {"--tiles: belongs to"});
  expect_bad_input(pair("--undistort all --alpha 1 --out " + path("no")),
                   {"--alpha: belongs to --rectify"});
  expect_bad_input("reproject " + path("set/images") + " " + path("rig/right/images") +
                       " --camera " + path("rig.yaml") + " --cameras left,right " + to,
                   {"must be 480x360 pixels", "got 640x400"});
  // A file of a camera without a place.
  spill(root() / "alone.yaml",
        "image_width: 480\nimage_height: 360\nmodel: pinhole\ncamera_matrix: {rows: 3, cols: 3, "
        "data: [400, 0, 240, 0, 400, 180, 0, 0, 1]}\n");
  expect_bad_input("reproject " + path("rig/left/images") + " " + path("rig/right/images") +
                       " --camera " + path("alone.yaml") + " " + to,
                   {"alone.yaml"});
  fs::remove(root() / "alone.yaml");
  EXPECT_EQ(names(), before);
}

TEST_F(CliRectify, PixelsBecomePoints) {
  const KnownRig cameras = rig();
  const std::vector<Eigen::Vector3d> points = {{0.1, 0.05, 0.8}, {-0.1, 0.02, 2}, {0.02, 0.1, 900}};
  std::string csv = "point,camera,u_px,v_px\n";
  for (std::size_t i = 0; i < points.size(); ++i)
    for (const KnownRig::Member& camera : cameras.cameras) {
      const auto pixel =
          project(camera.camera.camera.lens, camera.camera_from_rig * points[i]).value();
      csv += "p" + std::to_string(i) + "," + camera.name + "," + std::to_string(pixel.x()) + "," +
             std::to_string(pixel.y()) + "\n";
    }
  spill(root() / "pixels.csv", csv + "p3,left,100,100\n");
  const Outcome done = good_run("triangulate " + path("pixels.csv") + " --camera " +
                                path("rig.yaml") + " --sigma 0.2 --json");
  const Json rows = Json::parse(done.out)["points"];
  ASSERT_EQ(rows.size(), 4U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(rows[i]["status"], "ok");
    EXPECT_NEAR(rows[i]["x_m"].get<double>(), points[i].x(), 1e-3);
    EXPECT_NEAR(rows[i]["z_m"].get<double>(), points[i].z(), 1e-3);
    // 0.2 px of each camera, and the rig's own errors.
    const double z = points[i].z(), least = z * z * 0.2 * std::sqrt(2) / (400 * 0.08);
    EXPECT_GT(rows[i]["sigma_m"].get<double>(), 0.9 * least);
    EXPECT_LT(rows[i]["sigma_m"].get<double>(), 2 * least);
  }
  EXPECT_EQ(rows[2]["status"], "far");
  EXPECT_EQ(rows[3]["status"], "few_cameras");

  const std::string camera = " --camera " + path("rig.yaml");
  spill(root() / "wrong.csv", "point,camera,u_px,v_px\n1,middle,5,5\n");
  expect_bad_input("triangulate " + path("wrong.csv") + camera,
                   {"line 2", "must be a camera of the rig (left, right)", "middle"});
  spill(root() / "wrong.csv", "point,camera,u_px,v_px\n1,left,5,5\n1,left,6,6\n");
  expect_bad_input("triangulate " + path("wrong.csv") + camera, {"line 3", "must be given once"});
  spill(root() / "wrong.csv", "point,u_px,v_px\n");
  expect_bad_input("triangulate " + path("wrong.csv") + camera, {"camera"});
  // Pixels that contradict one another.
  spill(root() / "wrong.csv", "point,camera,u_px,v_px\n1,left,200,100\n1,right,180,160\n");
  const Outcome wrong = run("triangulate " + path("wrong.csv") + camera);
  EXPECT_HAS(wrong.out, ",left right\n");
  EXPECT_HAS(wrong.err, "contradict one another");
}

// Names that look like numbers, of which some are equal.
TEST_F(CliRectify, NamesOfPointsAndCamerasAreTexts) {
  std::string yaml = slurp(root() / "rig.yaml");
  yaml =
      replaced(replaced(yaml, "name: \"left\"", "name: \"1\""), "name: \"right\"", "name: \"2\"");
  spill(root() / "numbered.yaml", yaml);
  std::string csv = "point,camera,u_px,v_px\n";
  for (const std::string name : {"007", "7", "1e3", "nan"})
    csv += name + ",1,200,100\n" + name + ",2,180,160\n";
  spill(root() / "pixels.csv", csv);
  const Outcome done =
      run("triangulate " + path("pixels.csv") + " --camera " + path("numbered.yaml") + " --json");
  const Json rows = Json::parse(done.out)["points"];
  ASSERT_EQ(rows.size(), 4U) << done.err;
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(rows[i]["point"], Json({"007", "7", "1e3", "nan"})[i]);
  EXPECT_EQ(rows[0]["cameras"], 2);
  EXPECT_TRUE(rows[0]["contradicts"].is_string()) << done.out;
}

}  // namespace
}  // namespace tagcal::tools
