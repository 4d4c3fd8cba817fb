#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"

// tagcal check, from outside, and the sentence of diff.

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

const std::string kDesk = TAGCAL_SOURCE_DIR "/data-synthetic/golden/desk";

class CheckCli : public Cli {
 protected:
  static std::string camera() {
    static const std::string file = [] {
      const std::string name = path("desk-camera.yaml");
      EXPECT_EQ(run("calibrate " + kDesk + " --out " + name).exit_code, 0);
      return name;
    }();
    return file;
  }

  // A camera without a covariance, with another focal length.
  static std::string foreign(double focal_px, int width = 1280) {
    const std::string name = path("foreign.yaml");
    spill(name, "image_width: " + std::to_string(width) +
                    "\nimage_height: 800\n"
                    "camera_matrix: {rows: 3, cols: 3, dt: d, data: [" +
                    std::to_string(focal_px) + ", 0, 640, 0, " + std::to_string(focal_px) +
                    ", 400, 0, 0, 1]}\n"
                    "distortion_coefficients: {rows: 1, cols: 5, dt: d, data: [0, 0, 0, 0, 0]}\n");
    return name;
  }
};

TEST_F(CheckCli, AValidCameraEndsWithZero) {
  const Outcome outcome = run("check " + kDesk + " --camera " + camera());
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  EXPECT_TRUE(outcome.out.starts_with("VALID: ")) << outcome.out;
  const Json json = Json::parse(run("check " + kDesk + " --camera " + camera() + " --json").out);
  EXPECT_EQ(json["verdict"], "valid");
  EXPECT_LT(json["smallest_px"], 1);
  EXPECT_EQ(json["false_alarm"], 0.01);
}

TEST_F(CheckCli, AnotherCameraEndsWithOne) {
  const Outcome outcome = run("check " + kDesk + " --camera " + foreign(850));
  EXPECT_EQ(outcome.exit_code, 1) << outcome.out << outcome.err;
  EXPECT_TRUE(outcome.out.starts_with("CHANGED: ")) << outcome.out;
  EXPECT_HAS(outcome.out, "taken as exact");
}

TEST_F(CheckCli, BadInputIsOneLine) {
  const Outcome size = run("check " + kDesk + " --camera " + foreign(850, 640));
  EXPECT_EQ(size.exit_code, 2);
  EXPECT_EQ(std::ranges::count(size.err, '\n'), 1) << size.err;
  EXPECT_EQ(run("check " + kDesk).exit_code, 2);
  EXPECT_EQ(run("check " + kDesk + " --limit 0 --camera " + camera()).exit_code, 2);
  EXPECT_EQ(run("check " + kDesk + " --pair index --camera " + camera()).exit_code, 2);
}

// The order of the folders says nothing, and exchanged ones are named.
TEST_F(CheckCli, TheFoldersOfARig) {
  const std::string rig = path("rig.yaml"), corners = path("rig/");
  good_run("render " TAGCAL_SOURCE_DIR "/data-synthetic/scenes/stereo.yaml --views 8 --out " +
           path("rig"));
  const std::string target = " --target " + corners + "target.yaml";
  const std::string left = " " + corners + "left/images", right = " " + corners + "right/images";
  good_run("rig" + left + right + target + " --out " + rig);
  const auto check = [&](const std::string& folders) {
    return run("check" + target + folders + " --camera " + rig + " --json");
  };
  const Json as_rig = Json::parse(check(left + right).out)["cameras"];
  const Json other = Json::parse(check(right + left).out)["cameras"];
  for (int c = 0; c < 2; ++c)
    EXPECT_NEAR(as_rig[c]["sigma_px"].get<double>(), other[1 - c]["sigma_px"].get<double>(), 1e-4);
  fs::create_directories(root() / "swapped");
  fs::copy(root() / "rig/left", root() / "swapped/right", fs::copy_options::recursive);
  fs::copy(root() / "rig/right", root() / "swapped/left", fs::copy_options::recursive);
  const Outcome swapped =
      check(" " + path("swapped/left/images") + " " + path("swapped/right/images"));
  EXPECT_EQ(swapped.exit_code, 1);
  EXPECT_HAS(swapped.out, "the pictures agree with the rig if left and right exchange theirs");
}

// k1 is known well, the focal length is not: a pattern of the difference that is better known than
// all of them together.
TEST_F(CheckCli, DiffSaysWhyASmallDifferenceShows) {
  const auto file = [](const std::string& name, double k1) {
    spill(path(name),
          "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n"
          "camera_matrix: !!opencv-matrix {rows: 3, cols: 3, dt: d, data: [500, 0, 320, 0, 500, "
          "240, 0, 0, 1]}\n"
          "distortion_coefficients: !!opencv-matrix {rows: 1, cols: 5, dt: d, data: [" +
              std::to_string(k1) +
              ", 0, 0, 0, 0]}\nmodel: \"radial1\"\n"
              "covariance_names: [\"f\", \"cx\", \"cy\", \"k1\"]\n"
              "covariance: !!opencv-matrix {rows: 4, cols: 4, dt: d, data: [9, 0, 0, 0, 0, 1, 0, "
              "0, 0, 0, 1, 0, 0, 0, 0, 1e-8]}\n");
    return path(name);
  };
  const Outcome outcome =
      run("diff " + file("k1.yaml", -0.1) + " " + file("other-k1.yaml", -0.101) + " --limit 1");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.out << outcome.err;
  EXPECT_HAS(outcome.out, "CHANGED: 0.0");
  std::string words = outcome.out;
  std::ranges::replace(words, '\n', ' ');
  EXPECT_HAS(words, "of which they explain less");
}

}  // namespace
}  // namespace tagcal::tools
