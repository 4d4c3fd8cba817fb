// A grid of circles from outside: rendered, detected, calibrated, and held against the truth.
#include "cli_fixture.hpp"

namespace tagcal::tools {
namespace {

const std::string kCircles = std::string(TAGCAL_SOURCE_DIR) + "/data-synthetic/scenes/circles.yaml";

TEST_F(Cli, CirclesCalibrateWithinTheirClaims) {
  const std::string set = path("circles"), camera = path("circles_camera.yaml");
  ASSERT_EQ(run("render " + kCircles + " --out " + set).exit_code, 0);
  const Outcome detected = good_run("detect " + set + " --out " + path("circles.csv"));
  EXPECT_HAS(detected.out, "12 of 12 pictures show the target: 528 corners");
  const std::string corners = " --observations " + path("circles.csv");
  for (const std::string refined : {"", " --refine-corners"}) {
    const Outcome calibrated =
        good_run("calibrate " + set + corners + refined + " --out " + camera);
    EXPECT_LACKS(calibrated.err, "not refined");
    const Outcome truth = run("validate " + camera + " --dataset " + set + corners + " --truth");
    EXPECT_EQ(truth.exit_code, 0) << truth.out;
    EXPECT_HAS(truth.out, "truth: no parameter beyond 5 sd");
  }
}

// The caption and the scale beside the discs are no discs.
TEST_F(Cli, CirclesThatBoardPrintsAreFound) {
  const std::string pattern = "target_type: circlegrid\nspacingMeters: 0.016\n";
  spill(root() / "asymmetric.yaml",
        pattern + "targetCols: 4\ntargetRows: 11\nasymmetricGrid: true\n");
  spill(root() / "symmetric.yaml", pattern + "targetCols: 7\ntargetRows: 5\n");
  for (const std::string kind : {"asymmetric", "symmetric"}) {
    const std::string target = path(kind + ".yaml"), sheet = path(kind + "_sheet.png");
    const std::string printed = path(kind + "_sheet.yaml");  // may be smaller, to fit the paper
    good_run("board " + target + " --paper letter --landscape --dpi 150 --out " + sheet);
    const Outcome found =
        good_run("detect --target " + printed + " " + sheet + " --out " + path("n.csv"));
    EXPECT_HAS(found.out, "1 of 1 picture") << found.err;
  }
}

// As OpenCV orders centres: row by row from above, from the left.
TEST_F(Cli, CirclesConvertToOpenCvsListOfPoints) {
  spill(root() / "two.yaml",
        "target_type: circlegrid\ntargetCols: 2\ntargetRows: 2\nspacingMeters: 0.02\n");
  spill(root() / "two.csv",
        "image,tag_id,corner,x_px,y_px\na.png,0,0,10,40\na.png,1,0,30,40\na.png,2,0,10,20\n"
        "a.png,3,0,30,20\n");
  good_run("convert " + path("two.csv") + " " + path("two.yml") + " --target " + path("two.yaml") +
           " --to opencv");
  const std::string text = slurp(root() / "two.yml");
  EXPECT_HAS(text, "data: [ 10, 20, 30, 20, 10, 40, 30, 40 ]");
}

}  // namespace
}  // namespace tagcal::tools
