// A target file that does not describe the board in the pictures: `calibrate` says what `detect`
// found, and what it says to write makes the pictures calibrate.
#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"

namespace tagcal::tools {
namespace {

constexpr const char* kCharucoScene = R"(
camera: {image_size: [640, 400], model: f, f: 520}
boards:
  - target: {target_type: charuco, squareCols: 7, squareRows: 6, squareSize: 0.04, markerSize: 0.03, dictionary: DICT_4X4_250}
path: {type: dome, target_m: [0.14, 0.12, 0], min_distance_m: 0.4, max_distance_m: 0.5, min_elevation_deg: 45, max_elevation_deg: 80}
jitter: {target_m: 0.02, roll_deg: 20}
views: 6
sensor: {blur_px: 0.7, noise_levels: 2}
)";

constexpr const char* kCheckerScene = R"(
camera: {image_size: [640, 400], model: f, f: 520}
boards:
  - target: {target_type: checkerboard, targetCols: 6, targetRows: 5, rowSpacingMeters: 0.04, colSpacingMeters: 0.04}
path: {type: dome, target_m: [0.1, 0.08, 0], min_distance_m: 0.5, max_distance_m: 0.6, min_elevation_deg: 45, max_elevation_deg: 80}
jitter: {target_m: 0.02, roll_deg: 20}
views: 6
sensor: {blur_px: 0.7, noise_levels: 2}
)";

struct WrongTarget {
  std::string from, to;  // a change of the right file
  std::string says;
};

class CliWrongTarget : public Cli {
 protected:
  static void render(const std::string& name, const std::string& scene) {
    spill(root() / (name + ".scene.yaml"), scene);
    good_run("render " + path(name + ".scene.yaml") + " --out " + path(name));
  }

  // Replaces each "KEY: VALUE" of a file by those behind "write ".
  static std::string mended(std::string target, const std::string& message) {
    const std::size_t begin = message.find("write ");
    std::string line = message.substr(begin + 6, message.find('\n', begin) - begin - 6);
    line = std::regex_replace(line, std::regex("\\n\\s+"), " ");
    static const std::regex pair(R"(([A-Za-z_]+): ([A-Za-z0-9_.]*[A-Za-z0-9_]))");
    for (std::sregex_iterator it(line.begin(), line.end(), pair), end; it != end; ++it)
      target = std::regex_replace(target, std::regex((*it)[1].str() + ": [^\n]*"), it->str());
    return target;
  }

  // calibrate --target with a changed file is no answer, with the sentence; what it says helps.
  static void expect_mended(const std::string& set, const WrongTarget& wrong) {
    const std::string right = slurp(root() / set / "target.yaml");
    const std::string changed = replaced(right, wrong.from, wrong.to);
    spill(root() / "wrong.yaml", changed);
    const std::string rest = " " + path(set + "/images") + " --model f --json";
    const Outcome refused = run("calibrate --target " + path("wrong.yaml") + rest);
    SCOPED_TRACE(changed + refused.out + refused.err);
    EXPECT_EQ(refused.exit_code, 3);
    EXPECT_HAS(refused.out, wrong.says);
    const std::size_t at = refused.out.find(wrong.says);
    ASSERT_NE(at, std::string::npos);
    const std::string message = refused.out.substr(at, refused.out.find('"', at) - at) + "\n";
    spill(root() / "mended.yaml", mended(changed, message));
    const Outcome helped = run("calibrate --target " + path("mended.yaml") + rest);
    EXPECT_EQ(helped.exit_code, 0) << slurp(root() / "mended.yaml") << helped.out << helped.err;
    const Outcome detected =
        run("detect --target " + path("wrong.yaml") + " " + path(set + "/images"));
    EXPECT_HAS(detected.err, wrong.says);
  }
};

// No pose is given if corners have wrong numbers or places by the file, and each view says so.
TEST_F(CliWrongTarget, PosesSayIt) {
  using Json = nlohmann::json;
  const auto views = [](const std::string& from, const std::string& to) {
    const std::string right = slurp(root() / "set/target.yaml");
    spill(root() / "wrong.yaml", replaced(right, from, to));
    const Outcome outcome = run("pose --target " + path("wrong.yaml") + " " + path("set/images") +
                                " --camera " + path("set/truth.yaml") + " --json");
    return Json::parse(outcome.out)["views"];
  };
  for (const Json& view : views("tagSpacing: 0.3", "tagSpacing: 0.2")) {
    EXPECT_EQ(view["status"], "no_consensus") << view.dump();
    EXPECT_TRUE(view["camera_from_board"].is_null());
    EXPECT_HAS(view["warnings"].dump(), "wrong tag spacing");
  }
  for (const Json& view : views("tagCols: 4", "tagCols: 3")) {
    EXPECT_EQ(view["status"], "no_consensus") << view.dump();
    EXPECT_TRUE(view["camera_from_board"].is_null());
  }
}

// Corners at wrong places are no change of the camera.
TEST_F(CliWrongTarget, CheckTellsNothing) {
  const std::string right = slurp(root() / "set/target.yaml");
  spill(root() / "wrong.yaml", replaced(right, "tagSpacing: 0.3", "tagSpacing: 0.2"));
  const Outcome outcome = run("check --target " + path("wrong.yaml") + " " + path("set/images") +
                              " --camera " + path("set/truth.yaml"));
  EXPECT_EQ(outcome.exit_code, 3) << outcome.out;
  EXPECT_HAS(outcome.out, "do not test");
  EXPECT_HAS(outcome.out, "wrong tag spacing");
}

// A watched folder has no answer and no file either.
TEST_F(CliWrongTarget, WatchWritesNothing) {
  const std::string right = slurp(root() / "set/target.yaml");
  spill(root() / "wrong.yaml", replaced(right, "tagSpacing: 0.3", "tagSpacing: 0.5"));
  const Outcome outcome =
      run("watch --no-cache --every 0.03 --timeout 0.2 --target " + path("wrong.yaml") + " " +
          path("set/images") + " --out " + path("watched.yaml"));
  EXPECT_EQ(outcome.exit_code, 3) << outcome.out;
  EXPECT_HAS(outcome.out, "wrong tag spacing");
  EXPECT_FALSE(fs::exists(root() / "watched.yaml"));
}

TEST_F(CliWrongTarget, AprilGrids) {
  for (const WrongTarget& wrong : {WrongTarget{"tagCols: 4", "tagCols: 3", "wrong columns: "},
                                   {"tagCols: 4", "tagCols: 5", "wrong columns: "},
                                   {"tagSpacing: 0.3", "tagSpacing: 0.2", "wrong tag spacing: "},
                                   {"border_bits: 1", "border_bits: 2", "wrong border: "},
                                   {"\"tag36h11\"", "\"tag25h9\"", "wrong family: "},
                                   {"first_id: 0", "first_id: 1", "wrong first id: "},
                                   {"first_id: 0", "first_id: 4", "wrong first id: "}})
    expect_mended("set", wrong);
}

TEST_F(CliWrongTarget, CharucoBoards) {
  render("charuco", kCharucoScene);
  const std::string right = slurp(root() / "charuco/target.yaml");
  for (const WrongTarget& wrong :
       {WrongTarget{"squareCols: 7\nsquareRows: 6", "squareCols: 6\nsquareRows: 7",
                    "wrong squares: "},
        {"squareCols: 7\nsquareRows: 6", "squareCols: 6\nsquareRows: 5", "wrong squares: "},
        {"legacy: false", "legacy: true", "wrong pattern: "},
        {"DICT_4X4_250", "DICT_5X5_100", "wrong dictionary: "},
        {"first_marker_id: 0", "first_marker_id: 1", "wrong first id: "}})
    expect_mended("charuco", wrong);
  // Another size of the markers hides corners, but moves none.
  // A small error hides none, but their noise is several times as large.
  for (const std::string wrong : {"markerSize: 0.024", "markerSize: 0.028"}) {
    spill(root() / "size.yaml", replaced(right, "markerSize: 0.03", wrong));
    const Outcome size =
        run("calibrate --target " + path("size.yaml") + " " + path("charuco/images") + " --json");
    EXPECT_HAS(size.out, "wrong marker size: ");
  }
}

TEST_F(CliWrongTarget, Checkerboards) {
  render("checkers", kCheckerScene);
  const std::string right = "targetCols: 6\ntargetRows: 5";
  for (const WrongTarget& wrong :
       {WrongTarget{right, "targetCols: 5\ntargetRows: 4", "wrong size of grid: "},
        {right, "targetCols: 7\ntargetRows: 6", "wrong size of grid: "},
        {right, "targetCols: 8\ntargetRows: 5", "wrong size of grid: "}})
    expect_mended("checkers", wrong);
}

TEST_F(CliWrongTarget, MillimetresAreWarnedOfAndMayBeWritten) {
  const std::string right = slurp(root() / "set/target.yaml");
  spill(root() / "mm.yaml",
        std::regex_replace(right, std::regex("tagSize: [^\n]*"), "tagSize: 60"));
  const std::string rest = " " + path("set/images") + " --model f --json";
  const Outcome wide = run("calibrate --target " + path("mm.yaml") + rest);
  EXPECT_HAS(wide.out, "m wide: lengths are in metres; write 30mm");
  spill(root() / "mm.yaml",
        std::regex_replace(right, std::regex("tagSize: [^\n]*"), "tagSize: 60mm"));
  const Outcome fine =
      good_run("calibrate --target " + path("mm.yaml") + rest + " --distance 500mm");
  EXPECT_LACKS(fine.out, "m wide");
  expect_bad_input("calibrate " + path("set") + " --distance 3miles", {"--distance", "30mm"});
}

TEST_F(CliWrongTarget, PicturesWithoutABoardAreNoAnswer) {
  fs::create_directories(root() / "none");
  spill(root() / "none/a.pgm", "P5 640 400 255\n" + std::string(640 * 400, '\x80'));
  const Outcome none = run("calibrate --target " + path("set/target.yaml") + " " + path("none"));
  EXPECT_EQ(none.exit_code, 3) << none.err;
  EXPECT_TRUE(none.out.starts_with("NO ANSWER: the picture does not show the target")) << none.out;
}

}  // namespace
}  // namespace tagcal::tools
