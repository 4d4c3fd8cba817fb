// Location of corners in pictures, from outside: --refinement, --refine-corners, detect --camera.
#include <map>
#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"
#include "tagcal/io/dataset_file.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

TEST_F(Cli, EachRefinementGivesItsOwnCorners) {
  const std::string detect = "detect " + path("set") + " --refinement ";
  std::map<std::string, std::string> csv;
  for (const std::string name : {"stock", "edges", "fit"}) {
    const Outcome outcome = good_run(detect + name);
    csv[name] = outcome.out;
  }
  EXPECT_NE(csv["stock"], csv["edges"]);
  EXPECT_NE(csv["edges"], csv["fit"]);
  EXPECT_LACKS(csv["edges"], "sxx_px2");
  EXPECT_HAS(csv["fit"], "sxx_px2");
  EXPECT_EQ(run("detect " + path("set")).out, csv["fit"]);  // the default
  expect_bad_input(detect + "best", {"--refinement", "best"});
}

TEST_F(Cli, CornersAreRefinedUnderTheLensThatWasFound) {
  const std::string calibrate = "calibrate " + path("set") + " --model radial1 --json";
  const Outcome once = run(calibrate + " --out " + path("once.yaml"));
  const Outcome twice = run(calibrate + " --refine-corners --out " + path("twice.yaml"));
  ASSERT_EQ(once.exit_code, 0) << once.err;
  ASSERT_EQ(twice.exit_code, 0) << twice.err;
  const Json first = Json::parse(once.out), second = Json::parse(twice.out);
  EXPECT_EQ(first["seconds"]["refine"], 0);
  EXPECT_GT(second["seconds"]["refine"], 0);
  EXPECT_GT(second["seconds"]["write"], 0);
  EXPECT_NE(first["camera"]["fx"], second["camera"]["fx"]);
  EXPECT_LE(second["sigma"]["fx"].get<double>(), first["sigma"]["fx"].get<double>());
  EXPECT_NEAR(second["camera"]["fx"].get<double>(), 520, 5 * second["sigma"]["fx"].get<double>());
  const Outcome corners = good_run("detect " + path("set") + " --camera " + path("twice.yaml"));
  EXPECT_NE(corners.out, run("detect " + path("set")).out);
}

// With the camera_error_px of a calibration, `pose` uses the covariances of the corners.
TEST_F(Cli, PosesCountWithTheErrorOfTheCamera) {
  const std::string camera = path("own.yaml");
  ASSERT_EQ(run("calibrate " + path("set") + " --model radial1 --out " + camera).exit_code, 0);
  EXPECT_HAS(slurp(camera), "camera_error_px: ");
  const std::string pose = "pose " + path("set") + " --json --camera ";
  const Json own = Json::parse(run(pose + camera).out);
  spill(root() / "silent.yaml", replaced(slurp(camera), "camera_error_px", "other_error_px"));
  const Json silent = Json::parse(run(pose + path("silent.yaml")).out);
  const Json stated = Json::parse(run(pose + camera + " --camera-error-px 0.3").out);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(own["views"][i]["status"], "ok");
    EXPECT_TRUE(own["views"][i]["sigma_px"].is_null());  // each corner's own
    EXPECT_TRUE(silent["views"][i]["sigma_px"].is_number());
    EXPECT_GT(stated["views"][i]["noise_covariance"][5][5].get<double>(),
              100 * own["views"][i]["noise_covariance"][5][5].get<double>());
  }
}

TEST_F(Cli, RefiningNeedsPicturesAndACameraOfTheirSize) {
  const Outcome camera = good_run("calibrate " + path("set") + " --out " + path("camera.yaml"));
  spill(root() / "wide.yaml",
        replaced(slurp(root() / "camera.yaml"), "image_width: 640", "image_width: 800"));
  expect_bad_input("detect " + path("set") + " --camera " + path("wide.yaml"),
                   {"wide.yaml", "640x400", "800x400"});
  expect_bad_input("detect " + path("set") + " --camera " + path("none.yaml"), {"none.yaml"});
  const fs::path folder = root() / "corners-only";
  fs::copy(root() / "set", folder, fs::copy_options::recursive);
  fs::remove_all(folder / "images");
  spill(folder / "dataset.yaml", replaced(slurp(folder / "dataset.yaml"), "images: \"images\"",
                                          "observations: observations_exact.csv"));
  expect_bad_input("calibrate " + path("corners-only") + " --refine-corners",
                   {"corners-only", "no pictures"});
}

}  // namespace
}  // namespace tagcal::tools
