// tagcal render with a rig, from outside.
#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"

namespace tagcal::tools {
namespace {

const char* const kRig =
    "rig:\n"
    "  cameras:\n"
    "    - {name: left, camera: {image_size: [320, 240], model: pinhole, f: 250}}\n"
    "    - name: right\n"
    "      camera: {image_size: [400, 240], model: pinhole, f: 260}\n"
    "      rig_from_camera: {translation_m: [0.08, 0, 0]}\n"
    "      time_offset_ms: 20\n"
    "boards:\n"
    "  - target: {target_type: aprilgrid, tagCols: 4, tagRows: 4, tagSize: 0.08, tagSpacing: 0.3}\n"
    "    world_from_board: {translation_m: [-0.2, -0.2, 0]}\n"
    "path: {type: dome, min_distance_m: 0.6, max_distance_m: 0.8, min_elevation_deg: 45}\n"
    "jitter: {target_m: 0.05, roll_deg: 180}\n"
    "views: 6\n"
    "sensor: {blur_px: 0.6, noise_levels: 1}\n";

// The names of all files under a folder.
std::vector<std::string> files_under(const fs::path& folder) {
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(entry.path().lexically_relative(folder).string());
  std::sort(files.begin(), files.end());
  return files;
}

TEST_F(Cli, RendersADataSetForEachCameraOfARig) {
  spill(root() / "rig.yaml", kRig);
  const std::string render = "render " + path("rig.yaml") + " --out " + path("rig");
  const Outcome rendered = good_run(render + " --seed 3");
  EXPECT_HAS(rendered.err, "6 images of each of 2 cameras");
  const std::string dataset = slurp(root() / "rig/dataset.yaml");
  EXPECT_HAS(dataset, "observations: \"right/observations_exact.csv\"");
  const std::string times = slurp(root() / "rig/right/times.csv");
  EXPECT_TRUE(times.starts_with("image,time_s\n000.png,0\n001.png,0.05\n")) << times;
  EXPECT_HAS(slurp(root() / "rig/truth.yaml"), "time_offset_s: 0.02");
  const Outcome calibrated = good_run("calibrate " + path("rig/right") + " --model pinhole --json");
  const nlohmann::json answer = nlohmann::json::parse(calibrated.out);
  EXPECT_NEAR(answer["camera"]["fx"].get<double>(), 260, 1);

  // The first camera alone makes the same pictures.
  std::string alone = kRig;
  alone.replace(alone.find("rig:"), alone.find("boards:") - alone.find("rig:"),
                "camera: {image_size: [320, 240], model: pinhole, f: 250}\n");
  spill(root() / "alone.yaml", alone);
  ASSERT_EQ(run("render " + path("alone.yaml") + " --seed 3 --out " + path("alone")).exit_code, 0);
  EXPECT_TRUE(slurp(root() / "rig/left/images/004.png") == slurp(root() / "alone/images/004.png"));
}

TEST_F(Cli, ARigIsReplacedWholeAndTheUsersFilesStay) {
  spill(root() / "rig.yaml", kRig);
  const std::string render = "render " + path("rig.yaml") + " --out " + path("rig2");
  ASSERT_EQ(run(render).exit_code, 0);
  spill(root() / "rig2/left/notes.txt", "mine");
  expect_bad_input(render, {"holds an earlier render; --force replaces it"});
  good_run(render + " --force --views 2");
  EXPECT_EQ(files_under(root() / "rig2"),
            (std::vector<std::string>{
                "dataset.yaml", "left/dataset.yaml", "left/images/000.png", "left/images/001.png",
                "left/notes.txt", "left/observations_exact.csv", "left/target.yaml",
                "left/times.csv", "left/truth.yaml", "right/dataset.yaml", "right/images/000.png",
                "right/images/001.png", "right/observations_exact.csv", "right/target.yaml",
                "right/times.csv", "right/truth.yaml", "target.yaml", "truth.yaml"}));
  // A resumed render is the same to the last byte.
  const std::string resumed = "render " + path("rig.yaml") + " --views 2 --resume --depth --out ";
  ASSERT_EQ(run(resumed + path("rig3")).exit_code, 0);
  EXPECT_TRUE(slurp(root() / "rig3/right/images/001.png") ==
              slurp(root() / "rig2/right/images/001.png"));
  EXPECT_TRUE(fs::exists(root() / "rig3/right/depth/001.png"));
}

TEST_F(Cli, CommandsOfOneCameraNameTheCamerasOfARig) {
  spill(root() / "rig.yaml", kRig);
  ASSERT_EQ(run("render " + path("rig.yaml") + " --views 1 --out " + path("rig4")).exit_code, 0);
  for (const std::string command : {"detect ", "calibrate ", "pose --unknown-focal ", "view "})
    expect_bad_input(command + path("rig4"),
                     {"is the data set of a rig: use tagcal rig ", "/rig4/left"});
  expect_bad_input("view " + path("rig.yaml"), {"rig.yaml: rig: only tagcal render draws a rig"});
}

}  // namespace
}  // namespace tagcal::tools
