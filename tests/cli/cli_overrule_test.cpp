// calibrate --fix, --start, --focal and --keep-all.
#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

class CliOverrule : public Cli {
 protected:
  // Options come first: none of them takes the data set as a value.
  static std::string calibrate(const std::string& model, const std::string& first = "") {
    return "calibrate " + first + " " + path("set") + " --observations " +
           path("set/observations_exact.csv") + " --sigma-px 0.1 --model " + model + " ";
  }
};

TEST_F(CliOverrule, WhatIsFixedStandsInTheReportTheJsonAndTheFile) {
  const std::string fix = "--fix 'cx=317, k3=0' --fix cy=203 ";
  const Outcome text = run(calibrate("opencv5") + fix + "--out " + path("fixed.yaml"));
  ASSERT_EQ(text.exit_code, 0) << text.out << text.err;
  EXPECT_HAS(text.out, "held       cx 317, cy 203, k3 0, as asked");
  EXPECT_HAS(slurp(root() / "fixed.yaml"), "fixed: { cx: 317, cy: 203, k3: 0 }");
  const Json json = Json::parse(run(calibrate("opencv5", fix) + "--json").out);
  EXPECT_EQ(json["fixed"], (Json{{"cx", 317}, {"cy", 203}, {"k3", 0}}));
  EXPECT_EQ(json["camera"]["cx"], 317);
  EXPECT_EQ(json["sigma"]["cx"], 0);
  // The file is read again, with the covariance of the free parameters.
  EXPECT_EQ(run("validate " + path("fixed.yaml") + " --dataset " + path("set")).exit_code, 0);
  EXPECT_EQ(run(calibrate("opencv5") + "--start " + path("fixed.yaml")).exit_code, 0);
}

TEST_F(CliOverrule, StartsAndKeepAll) {
  EXPECT_EQ(run(calibrate("radial1") + "--focal 500").exit_code, 0);
  EXPECT_EQ(run(calibrate("radial1") + "--keep-all").exit_code, 0);
  EXPECT_EQ(run(calibrate("auto") + "--fix f=520").exit_code, 0);
}

TEST_F(CliOverrule, WhatIsWrongIsOneLine) {
  expect_bad_input(calibrate("opencv5") + "--fix k9=1", {"--fix: must be one of", "k9"});
  expect_bad_input(calibrate("opencv5") + "--fix cx", {"--fix", "NAME=VALUE", "cx"});
  expect_bad_input(calibrate("opencv5") + "--fix cx=wide", {"--fix", "cx=wide"});
  expect_bad_input(calibrate("opencv5") + "--fix cx=1 --fix cx=2", {"--fix", "twice"});
  expect_bad_input(calibrate("opencv5") + "--fix f=-1", {"--fix: f must be > 0"});
  expect_bad_input(calibrate("auto") + "--fix k1=0", {"k1 needs a model by its name"});
  expect_bad_input(calibrate("opencv5") + "--tolerance 1", {"--tolerance: needs model auto"});
  expect_bad_input(calibrate("weak") + "--board-warp", {"--board-warp: model weak has no"});
  expect_bad_input(calibrate("opencv6"), {"--model: must be auto, ", "opencv6"});
  expect_bad_input(calibrate("opencv5") + "--focal -5", {"--focal", "-5"});
  expect_bad_input(calibrate("opencv5") + "--start " + path("none.yaml"), {"none.yaml"});
  spill(root() / "fisheye.yaml",
        "image_width: 640\nimage_height: 400\nmodel: fisheye4\n"
        "camera_matrix: {rows: 3, cols: 3, dt: d, data: [520, 0, 317, 0, 520, 203, 0, 0, 1]}\n"
        "distortion_coefficients: {rows: 1, cols: 4, dt: d, data: [0, 0, 0, 0]}\n");
  const std::string fisheye = "--start " + path("fisheye.yaml");
  expect_bad_input(calibrate("opencv5") + fisheye, {"--start: is a fisheye", "opencv5"});
  expect_bad_input(calibrate("fisheye4") + fisheye + " --focal 500", {"--start, --focal"});
  spill(root() / "small.yaml", replaced(slurp(root() / "fisheye.yaml"), "640", "320"));
  expect_bad_input(calibrate("fisheye4") + "--start " + path("small.yaml"),
                   {"--start", "640x400", "320x400"});
}

}  // namespace
}  // namespace tagcal::tools
