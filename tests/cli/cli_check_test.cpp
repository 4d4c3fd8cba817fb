#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"
#include "report/lens_comparison.hpp"

// tagcal check, from outside; and the sentences of its verdicts.

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
  EXPECT_NE(outcome.out.find("taken as exact"), std::string::npos) << outcome.out;
}

TEST_F(CheckCli, BadInputIsOneLine) {
  const Outcome size = run("check " + kDesk + " --camera " + foreign(850, 640));
  EXPECT_EQ(size.exit_code, 2);
  EXPECT_EQ(std::ranges::count(size.err, '\n'), 1) << size.err;
  EXPECT_EQ(run("check " + kDesk).exit_code, 2);
  EXPECT_EQ(run("check " + kDesk + " --limit 0 --camera " + camera()).exit_code, 2);
  EXPECT_EQ(run("check " + kDesk + " --pair index --camera " + camera()).exit_code, 2);
}

// A pattern of difference that is better known than all of them together.
TEST(ComparisonVerdict, ASmallDifferenceThatShowsSaysWhy) {
  Comparison comparison;
  comparison.difference.distance_m = 1;
  comparison.difference.rms_px = comparison.difference.max_px = 0.12;
  comparison.test = DifferenceTest{.expected_px = 0.46, .in_sigmas = 2.4, .smallest_px = 0.3};
  const ComparisonVerdict small = verdict_of({&comparison, 1});
  EXPECT_EQ(small.word, "CHANGED");
  EXPECT_NE(small.sentence.find("explain 0.46 px in all, but less than was found of this pattern"),
            std::string::npos)
      << small.sentence;
  EXPECT_TRUE(small.sentence.ends_with("(score 2.4)")) << small.sentence;
  comparison.difference.rms_px = comparison.difference.max_px = 0.92;
  const ComparisonVerdict large = verdict_of({&comparison, 1});
  EXPECT_EQ(large.sentence.find("pattern"), std::string::npos) << large.sentence;
}

}  // namespace
}  // namespace tagcal::tools
