#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"
#include "job/terminal.hpp"

// What commands print: as wide as the terminal, little with --quiet, JSON for programs, and "-" for
// stdout.

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

TEST(Terminal, LongLinesAreWrappedBelowTheirLabels) {
  EXPECT_EQ(fitted("short\nrms    0.2 px of all the corners\n", 20),
            "short\nrms    0.2 px of all\n       the corners\n");
  EXPECT_EQ(fitted("  one two three four", 10), "  one two\n    three\n    four");
  EXPECT_EQ(fitted("a  1   2  b c", 12), "a  1   2  b\n   c");
  EXPECT_EQ(fitted("/a/name/longer/than/the/line is", 10), "/a/name/longer/than/the/line\n  is");
  EXPECT_EQ(fitted(toned(Tone::good, "OK") + ": 1\n", 5), toned(Tone::good, "OK") + ": 1\n");
}

// Wrapped once: no line is longer than the terminal, which would wrap it again.
TEST_F(Cli, TextIsAsWideAsTheTerminal) {
  const std::string set = path("set"), camera = path("wide.yaml"), target = path("set/target.yaml");
  ASSERT_EQ(run("calibrate " + set + " --out " + camera).exit_code, 0);
  setenv("COLUMNS", "80", 1);
  for (const std::string& command :
       {std::string(), "calibrate " + set + " --verbose --advise", "detect " + set + " --verbose",
        "pose " + set + " --camera " + camera, "validate " + camera + " --dataset " + set,
        "diff " + camera + " " + camera, "calibrate " + set + " " + set,
        std::string("calibrate --modell x"), "view " + set,
        "detect " + path("set/images") + " --target " + target + " --explain",
        "calibrate " + set + " --model f --select 2 --keep-all"}) {
    const Outcome outcome = run(command);
    const bool is_csv = command.starts_with("detect");
    std::istringstream lines((is_csv ? "" : outcome.out) + outcome.err);
    for (std::string line; std::getline(lines, line);)
      EXPECT_TRUE(line.size() <= 80 || line.find(root().string()) != std::string::npos)
          << command << "\n"
          << line;
  }
  unsetenv("COLUMNS");
}

TEST_F(Cli, QuietCommandsSayOnlyWhatIsWrong) {
  const std::string set = path("set"), camera = path("quiet.yaml");
  for (const std::string& command :
       {"calibrate " + set + " --out " + camera, "detect " + set + " --out " + path("quiet.csv"),
        "board " + path("set/target.yaml") + " --out " + path("quiet.svg"),
        "convert " + camera + " " + path("quiet.ros.yaml") + " --to ros",
        "report " + camera + " --out " + path("quiet.html"),
        "render " + path("scene.yaml") + " --views 1 --out " + path("quiet")}) {
    const Outcome outcome = run(command + " --quiet");
    EXPECT_EQ(outcome.exit_code, 0) << command;
    EXPECT_EQ(outcome.out, "") << command;
    std::istringstream lines(outcome.err);
    for (std::string line; std::getline(lines, line);)
      EXPECT_TRUE(line.starts_with("tagcal: warning: ") || line.starts_with(path("quiet.ros")))
          << command << "\n"
          << line;
  }
  EXPECT_HAS(run("calibrate " + set + " --quiet").out, "fx");
  expect_bad_input("calibrate " + path("none") + " --quiet", {path("none")});
}

TEST_F(Cli, CommandsThatOnlyWriteSayWhatInJson) {
  const std::string set = path("set"), camera = path("json.yaml"), target = path("set/target.yaml");
  ASSERT_EQ(run("calibrate " + set + " --out " + camera).exit_code, 0);
  const std::map<std::string, std::string> commands = {
      {path("json.svg"), "board " + target + " --out "},
      {path("json.html"), "report " + camera + " --out "},
      {path("json.xml"), "convert " + camera + " "},
      {path("json_set"), "render " + path("scene.yaml") + " --views 1 --out "},
      {path("json_flat"), "reproject --camera " + camera + " " + path("set/images/000.png") +
                              " --undistort all --out "}};
  for (const auto& [out, command] : commands) {
    const Outcome outcome = good_run(command + out + " --json");
    const Json json = Json::parse(outcome.out);
    EXPECT_EQ(json["wrote"][0]["file"], out) << command;
    EXPECT_EQ(json["exit_code"], 0);
    EXPECT_TRUE(json["messages"].is_array());
  }
}

TEST_F(Cli, TablesAreJsonToo) {
  const std::string set = path("set"), camera = path("table.yaml");
  const Outcome csv = run("detect " + set);
  const Json found = Json::parse(run("detect " + set + " --json").out);
  EXPECT_EQ(found["pictures"].size(), 6u);
  EXPECT_EQ(found["corners"].size(), std::count(csv.out.begin(), csv.out.end(), '\n') - 1);
  EXPECT_TRUE(found["corners"][0]["x_px"].is_number()) << found["corners"][0];
  const Json tags =
      Json::parse(run("detect --family tag36h11 " + path("set/images/000.png") + " --json").out);
  EXPECT_EQ(tags["pictures"][0]["image"], "000.png");
  ASSERT_EQ(run("calibrate " + set + " --out " + camera).exit_code, 0);
  spill(path("point.csv"), "name,x,y,z\nnut,0,0,1\n,0,0,-1\n");
  const Json points =
      Json::parse(run("project " + path("point.csv") + " --camera " + camera + " --json").out);
  EXPECT_EQ(points["points"][0]["name"], "nut");
  EXPECT_TRUE(points["points"][0]["u_px"].is_number());
  EXPECT_TRUE(points["points"][1]["u_px"].is_null());
}

TEST_F(Cli, ADashIsStandardOutputForText) {
  const std::string set = path("set"), camera = path("dash.yaml");
  ASSERT_EQ(run("calibrate " + set + " --out " + camera).exit_code, 0);
  const Outcome calibrated = run("calibrate " + set + " --out -");
  EXPECT_EQ(calibrated.out, slurp(camera));
  EXPECT_HAS(calibrated.err, "\n  fx ");
  EXPECT_EQ(run("detect " + set + " --out -").out, run("detect " + set).out);
  const Outcome converted = run("convert " + camera + " - --to ros");
  EXPECT_HAS(converted.out, "camera_matrix") << converted.err;
  EXPECT_FALSE(fs::exists("-"));
  for (const std::string& command :
       {"board " + path("set/target.yaml"), "render " + path("scene.yaml"),
        "reproject --camera " + camera + " x.png --undistort all"})
    expect_bad_input(command + " --out -", {"--out: - is standard output, which takes text only"});
}

}  // namespace
}  // namespace tagcal::tools
