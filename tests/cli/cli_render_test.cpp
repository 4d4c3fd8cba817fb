// tagcal render with 16 bits a pixel, from outside.
#include "cli_fixture.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
namespace {

TEST_F(Cli, RendersSixteenBitsThatAreDetectedAndCalibratedFrom) {
  spill(root() / "deep.yaml", replaced(kScene, "noise_levels: 2", "noise_levels: 2, bits: 16"));
  const Outcome rendered = run("render " + path("deep.yaml") + " --out " + path("deep"));
  ASSERT_EQ(rendered.exit_code, 0) << rendered.err;
  const std::string picture = slurp(root() / "deep/images/000.png");
  ASSERT_GT(picture.size(), 25u);
  EXPECT_EQ(picture[24], 16);  // the bit depth, in a PNG's first chunk
  EXPECT_EQ(slurp(root() / "set/images/000.png")[24], 8);
  EXPECT_EQ(slurp(root() / "deep/observations_exact.csv"),
            slurp(root() / "set/observations_exact.csv"));

  const Outcome shallow = run("detect " + path("set"));
  const Outcome deep = run("detect " + path("deep"));
  ASSERT_EQ(deep.exit_code, 0) << deep.err;
  const auto lines = [](const std::string& text) {
    return std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_EQ(lines(deep.out), lines(shallow.out));
  EXPECT_GT(lines(deep.out), 200);
  EXPECT_EQ(run("calibrate " + path("deep")).exit_code, 0);
}

TEST_F(Cli, BitsThatNoPictureHasAreBadInput) {
  spill(root() / "twelve.yaml", replaced(kScene, "noise_levels: 2", "bits: 12"));
  expect_bad_input("render " + path("twelve.yaml") + " --out " + path("twelve"),
                   {"twelve.yaml: sensor.bits: must be 8 or 16, got 12"});
  EXPECT_FALSE(fs::exists(root() / "twelve"));
}

}  // namespace
}  // namespace tagcal::tools
