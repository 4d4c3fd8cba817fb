// tagcal render with 16 bits a pixel, from outside.
#include <array>

#include "cli_fixture.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
namespace {

TEST_F(Cli, RendersSixteenBitsThatAreDetectedAndCalibratedFrom) {
  spill(root() / "deep.yaml", replaced(kScene, "noise_levels: 2", "noise_levels: 2, bits: 16"));
  good_run("render " + path("deep.yaml") + " --out " + path("deep"));
  const std::string picture = slurp(root() / "deep/images/000.png");
  ASSERT_GT(picture.size(), 25u);
  EXPECT_EQ(picture[24], 16);  // the bit depth, in a PNG's first chunk
  EXPECT_EQ(slurp(root() / "set/images/000.png")[24], 8);
  EXPECT_EQ(slurp(root() / "deep/observations_exact.csv"),
            slurp(root() / "set/observations_exact.csv"));

  const Outcome shallow = run("detect " + path("set"));
  const Outcome deep = good_run("detect " + path("deep"));
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

TEST_F(Cli, DepthsAreWrittenBesideThePictures) {
  const Outcome rendered =
      good_run("render " + path("scene.yaml") + " --out " + path("depths") + " --depth");
  EXPECT_LACKS(rendered.err, "--depth-unit-m");
  EXPECT_TRUE(slurp(root() / "depths/images/000.png") == slurp(root() / "set/images/000.png"));
  EXPECT_HAS(slurp(root() / "depths/dataset.yaml"), "depth: {folder: \"depth\", unit_m: 0.001}");
  const std::string picture = slurp(root() / "depths/depth/001.png");
  ASSERT_GT(picture.size(), 25u);
  EXPECT_EQ(picture[24], 16);
  EXPECT_EQ(run("detect " + path("depths")).exit_code, 0);

  // 65535 units of 1 um end before the board.
  const Outcome fine = good_run("render " + path("scene.yaml") + " --out " + path("fine") +
                                " --depth --depth-unit-m 1e-6 --views 1");
  EXPECT_HAS(fine.err, "pixels is not between 1e-06 and 0.065535 m");
  expect_bad_input("render " + path("scene.yaml") + " --out " + path("no") + " --depth-unit-m 1",
                   {"--depth-unit-m: belongs to --depth"});
  expect_bad_input(
      "render " + path("scene.yaml") + " --out " + path("no") + " --depth --depth-unit-m 0",
      {"--depth-unit-m"});
}

std::map<std::string, std::array<double, 2>> corners_of(const std::string& csv) {
  std::map<std::string, std::array<double, 2>> corners;
  std::istringstream lines(csv);
  std::string line, x, y;
  std::getline(lines, line);  // the header
  while (std::getline(lines, line)) {
    std::istringstream fields(line);
    std::string image, tag, corner;
    for (std::string* field : {&image, &tag, &corner, &x, &y}) std::getline(fields, *field, ',');
    corners[image + "," + tag + "," + corner] = {std::stod(x), std::stod(y)};
  }
  return corners;
}

// Vignetting, and a lamp before the board: as many corners are found as in even light. The fit of a
// tag assumes that the light changes linearly over it and that black does not change: what is left
// is systematic, 0.01 px with vignetting and 0.04 px with the lamp (RMS per coordinate; 0.008 px in
// even light).
TEST_F(Cli, CornersAreFoundInUnevenLight) {
  const auto even = corners_of(run("detect " + path("set")).out);
  const std::string vignetted =
      replaced(kScene, "noise_levels: 2", "noise_levels: 2, vignetting: [-0.4, -0.3]");
  const std::string lamp =
      "light: {ambient: 0.15, point: {position_m: [0.05, 0.1, 0.25], "
      "strength: 0.06}}\n";
  const std::pair<std::string, double> scenes[] = {
      {kScene, 0.015}, {vignetted, 0.02}, {vignetted + lamp, 0.06}};
  for (const auto& [scene, most_px] : scenes) {
    spill(root() / "uneven.yaml", scene);
    fs::remove_all(root() / "uneven");
    good_run("render " + path("uneven.yaml") + " --out " + path("uneven"));
    const auto exact = corners_of(slurp(root() / "uneven/observations_exact.csv"));
    const auto found = corners_of(run("detect " + path("uneven")).out);
    EXPECT_GE(found.size(), even.size());
    double squares = 0;
    for (const auto& [id, pixel] : found) {
      ASSERT_TRUE(exact.contains(id)) << id;
      squares += std::pow(pixel[0] - exact.at(id)[0], 2) + std::pow(pixel[1] - exact.at(id)[1], 2);
    }
    const double rms_px = std::sqrt(squares / (2.0 * static_cast<double>(found.size())));
    std::printf("%zu corners, rms %.4f px\n", found.size(), rms_px);
    EXPECT_LT(rms_px, most_px);
    EXPECT_EQ(run("calibrate " + path("uneven") + " --model radial1").exit_code, 0);
  }
}

TEST_F(Cli, ALightThatCannotBeIsBadInput) {
  const std::string scene = kScene;
  const auto refused = [&](const std::string& text, const std::string& message) {
    spill(root() / "dark.yaml", text);
    expect_bad_input("render " + path("dark.yaml") + " --out " + path("dark"), {message});
    EXPECT_FALSE(fs::exists(root() / "dark"));
  };
  refused(scene + "light: {point: {position_m: [0, 0, 1], strength: 1}, frame: pole}\n",
          "dark.yaml: light.frame: ");
  refused(scene + "light: {directional: {direction: [0, 0, 0], strength: 1}}\n",
          "dark.yaml: light.directional.direction: must not be zero");
  refused(replaced(scene, "noise_levels: 2", "vignetting: [-2]"),
          "dark.yaml: sensor: vignetting: must not be negative");
}

TEST_F(Cli, WarnsWhereNothingIsVisible) {
  spill(root() / "away.yaml",
        replaced(kScene, "target_m: [0.14, 0.1, 0]", "target_m: [90, 90, 0]"));
  const Outcome away = good_run("render " + path("away.yaml") + " --out " + path("away"));
  EXPECT_HAS(away.err, "warning: no corner of a board is visible in any picture");
  EXPECT_LACKS(run("render " + path("scene.yaml") + " --out " + path("seen")).err, "warning");
}

}  // namespace
}  // namespace tagcal::tools
