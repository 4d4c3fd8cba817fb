// The command from outside: exit codes, streams, files.
#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

TEST_F(Cli, HelpOfEachCommandHasAnExample) {
  for (const std::string command :
       {"", "render", "detect", "calibrate", "validate", "pose", "board"}) {
    const Outcome help = good_run(command + " --help");
    EXPECT_HAS(help.out, "Example: tagcal");
    EXPECT_EQ(help.err, "");
  }
  EXPECT_EQ(run("--version").out.substr(0, 7), "tagcal ");
}

TEST_F(Cli, RenderGivesEqualBytesForAnyNumberOfThreads) {
  for (const std::string threads : {"1", "2", "5"}) {
    const Outcome outcome = good_run("render " + path("scene.yaml") + " --seed 3 --views 3 --out " +
                                     path("t" + threads) + " --threads " + threads);
    EXPECT_EQ(outcome.out, "");
  }
  const auto one = bytes_of(root() / "t1");
  EXPECT_EQ(one.size(), 3u + 4u);
  EXPECT_EQ(one, bytes_of(root() / "t2"));
  EXPECT_EQ(one, bytes_of(root() / "t5"));
  const auto other_seed = bytes_of(root() / "set");
  EXPECT_NE(one.at("images/000.png"), other_seed.at("images/000.png"));
  EXPECT_NE(one.at("truth.yaml"), other_seed.at("truth.yaml"));
}

TEST_F(Cli, RenderingAgainReplacesTheRenderAndKeepsTheUsersFiles) {
  const std::string out = path("again");
  const std::string command = "render " + path("scene.yaml") + " --out " + out;
  ASSERT_EQ(run(command + " --views 3").exit_code, 0);
  spill(root() / "again/notes.txt", "mine");
  spill(root() / "again/images/mine.txt", "mine too");
  spill(root() / "again/results/deep/camera.yaml", "mine as well");
  ASSERT_EQ(run(command + " --force --views 2/ ").exit_code, 2);
  const auto before = bytes_of(out);
  expect_bad_input(command + " --views 2", {"again", "holds an earlier render", "--force"});
  EXPECT_EQ(bytes_of(out), before);
  ASSERT_EQ(run(command + "/ --force --views 2").exit_code, 0);
  const auto files = bytes_of(out);
  EXPECT_EQ(files.at("notes.txt"), "mine");
  EXPECT_EQ(files.at("images/mine.txt"), "mine too");
  EXPECT_EQ(files.at("results/deep/camera.yaml"), "mine as well");
  EXPECT_TRUE(files.contains("images/001.png"));
  EXPECT_FALSE(files.contains("images/002.png"));
  EXPECT_EQ(files.size(), 2u + 4u + 3u);
  for (const std::string& name : names()) {
    EXPECT_LACKS(name, "again.") << "left behind: ";
  }
}

TEST_F(Cli, RenderLeavesNothingHalfWritten) {
  spill(root() / "foreign/photo.txt", "keep me");
  spill(root() / "file", "");
  spill(root() / "bad_family.yaml",
        replaced(kScene, "border_bits: 1,", "border_bits: 1, family: tag9h9,"));
  spill(root() / "bad_id.yaml",
        replaced(kScene, "border_bits: 1,", "border_bits: 1, first_id: 9999,"));
  const auto before = names();
  const std::string scene = path("scene.yaml");
  expect_bad_input("render " + scene + " --out " + path("foreign"),
                   {"foreign", "must be empty or an earlier render"});
  expect_bad_input("render " + scene + " --force --out " + path("foreign"),
                   {"foreign", "must be empty or an earlier render"});
  expect_bad_input("render " + scene + " --out " + path("file"), {"file", "must be a folder"});
  expect_bad_input("render " + scene + " --out " + path("file/below"), {"file/below"});
  expect_bad_input("render " + scene + " --out /proc/nowhere",
                   {"/proc/nowhere", "cannot be written"});
  expect_bad_input("render " + path("bad_family.yaml") + " --out " + path("new"), {"tag9h9"});
  expect_bad_input("render " + path("bad_id.yaml") + " --out " + path("new"), {"9999"});
  expect_bad_input("render " + path("none.yaml") + " --out " + path("new"), {"none.yaml"});
  EXPECT_EQ(names(), before);
  EXPECT_EQ(slurp(root() / "foreign/photo.txt"), "keep me");
}

TEST_F(Cli, DetectWritesTheSameToStdoutAndToAFile) {
  const Outcome to_stdout = good_run("detect " + path("set"));
  const Outcome to_file =
      good_run("detect " + path("set") + " --threads 1 --out " + path("corners.csv"));
  EXPECT_TRUE(to_file.out.starts_with("OK: 6 of 6 pictures show the target: ")) << to_file.out;
  EXPECT_EQ(slurp(root() / "corners.csv"), to_stdout.out);
  EXPECT_TRUE(to_stdout.out.starts_with("image,tag_id,corner,x_px,y_px"));
  const auto lines = std::count(to_stdout.out.begin(), to_stdout.out.end(), '\n');
  const std::string exact = slurp(root() / "set/observations_exact.csv");
  EXPECT_GT(lines, std::count(exact.begin(), exact.end(), '\n') * 8 / 10);
  EXPECT_HAS(to_stdout.err, "OK: 6 of 6 pictures");

  const Outcome pictures =
      good_run("detect --target " + path("set/target.yaml") + " " + path("set/images") + "/*.png");
  EXPECT_EQ(pictures.out, to_stdout.out);
}

TEST_F(Cli, DetectThatFindsNothingSaysSoAndIsNoError) {
  spill(root() / "black.pgm", "P5 64 48 255\n" + std::string(64 * 48, '\0'));
  const Outcome outcome =
      good_run("detect --target " + path("set/target.yaml") + " " + path("black.pgm"));
  EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 1);
  EXPECT_HAS(outcome.err, "NOTHING FOUND: the target is not in the picture");
}

TEST_F(Cli, CalibratesWhatItRenderedAndPrintsOneJsonObject) {
  const std::string camera = path("camera.yaml");
  const Outcome outcome =
      run("calibrate " + path("set") + " --model radial1 --json --out " + camera);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  const Json json = Json::parse(outcome.out);
  std::size_t last = 0;
  for (const char* key :
       {"status", "model", "camera", "sigma", "claim", "rms_px", "sigma_px", "sigma_of_corners",
        "corner_error_px", "model_error_px", "num_views", "num_corners", "num_outliers", "views",
        "findings", "warnings", "seconds"}) {
    EXPECT_TRUE(json.contains(key)) << key;
    const std::size_t at = outcome.out.find("\n  \"" + std::string(key) + "\":");
    EXPECT_GT(at, last) << key;  // in this order
    last = at;
  }
  EXPECT_EQ(json.size(), 30u);
  EXPECT_EQ(json["status"], "ok");
  EXPECT_EQ(json["model"], "radial1");
  EXPECT_EQ(json["num_views"], 6);
  const double truth[] = {520, 520, 317, 203};
  const char* names[] = {"fx", "fy", "cx", "cy"};
  for (int i = 0; i < 4; ++i) {
    const double sigma = json["sigma"][names[i]];
    EXPECT_GT(sigma, 0);
    EXPECT_LT(sigma, 20);
    EXPECT_NEAR(json["camera"][names[i]].get<double>(), truth[i], 5 * sigma) << names[i];
  }
  EXPECT_EQ(json["camera"]["distortion"].size(), 5u);
  EXPECT_NEAR(json["camera"]["distortion"][0].get<double>(), -0.1,
              5 * json["sigma"]["distortion"][0].get<double>());
  EXPECT_EQ(json["sigma"]["distortion"][1], 0);
  EXPECT_LT(json["rms_px"], 0.5);
  double named = 0;
  for (const char* step : {"read", "refine", "start", "solve", "covariance", "write"}) {
    EXPECT_GE(json["seconds"][step], 0) << step;
    named += json["seconds"][step].get<double>();
  }
  EXPECT_LE(named, json["seconds"]["total"].get<double>());

  const Outcome valid = run("validate " + camera + " --dataset " + path("set") + " --json");
  EXPECT_EQ(valid.exit_code, 0) << valid.out << valid.err;
  const Json validation = Json::parse(valid.out);
  EXPECT_EQ(validation["passed"], true);
  EXPECT_LT(validation["max_projection_difference_px"], 1e-9);
  EXPECT_FALSE(validation["parameters"].empty());
  EXPECT_EQ(validation["opencv_agrees"], true);
  EXPECT_EQ(validation["parameters_beyond_5_sd"], 0);
  const std::string text = run("validate " + camera + " --dataset " + path("set")).out;
  EXPECT_TRUE(text.ends_with("OpenCV agrees\ntruth: no parameter beyond 5 sd\n")) << text;
}

TEST_F(Cli, ValidateJudgesTheTruthWhereItIsAsked) {
  const std::string camera = path("judged.yaml");
  ASSERT_EQ(run("calibrate " + path("set") + " --model radial1 --out " + camera).exit_code, 0);
  const std::string command = "validate " + camera + " --dataset ";
  EXPECT_EQ(run(command + path("set") + " --truth").exit_code, 0);
  // The camera alone, whose standard deviations are not known.
  const std::string unknown = path("unknown.yaml");
  const std::string file = slurp(camera);
  spill(unknown, file.substr(0, file.find("avg_reprojection_error")));
  const std::string without = "validate " + unknown + " --dataset " + path("set");
  EXPECT_HAS(run(without).out, "not known");
  EXPECT_LACKS(run(without).out, " sd\n");
  const Json fx = Json::parse(run(without + " --json").out)["parameters"][0];
  EXPECT_TRUE(fx["sigma"].is_null() && fx["in_sigmas"].is_null()) << fx;
  // The same answer, compared with a truth of another principal point.
  const fs::path wrong = exact_set("wrong_truth");
  const std::string truth = slurp(wrong / "truth.yaml");
  spill(wrong / "truth.yaml",
        replaced(replaced(truth, "cx: 317", "cx: 327"), "cy: 203", "cy: 213"));
  const Outcome shown = good_run(command + wrong.string());
  EXPECT_TRUE(shown.out.ends_with("OpenCV agrees\ntruth: 2 parameters beyond 5 sd\n")) << shown.out;
  EXPECT_LACKS(shown.out, "passed");
  EXPECT_EQ(run(command + wrong.string() + " --truth").exit_code, 1);
  const Outcome json = run(command + wrong.string() + " --truth --json");
  EXPECT_EQ(json.exit_code, 1);
  EXPECT_EQ(Json::parse(json.out)["passed"], false);
  EXPECT_EQ(Json::parse(json.out)["parameters_beyond_5_sd"], 2);
  spill(wrong / "dataset.yaml", replaced(slurp(wrong / "dataset.yaml"), "truth: truth.yaml\n", ""));
  expect_bad_input(command + wrong.string() + " --truth",
                   {"--truth", "wrong_truth", "has no truth"});
  EXPECT_EQ(run(command + wrong.string()).exit_code, 0);
}

TEST_F(Cli, TheSummaryNamesModelStatusAndParameters) {
  const std::string observations = " --observations " + path("set/observations_exact.csv");
  const Outcome outcome =
      run("calibrate " + path("set") + observations + " --sigma-px 0.1 --model radial1");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  for (const char* part : {"OK, 1 warning: radial1, ", "fx ", "+- ", "held", "rms ", "as stated"}) {
    EXPECT_HAS(outcome.out, part);
  }
}

// Frontal views of a board do not determine the focal length apart from the distance.
TEST_F(Cli, WithoutAnAnswerTheJsonSaysSoAndNothingIsWritten) {
  const std::string flat = replaced(
      kScene,
      "type: dome, target_m: [0.14, 0.1, 0], min_distance_m: 0.45, "
      "max_distance_m: 0.6, min_elevation_deg: 45, max_elevation_deg: 80",
      "type: line, from_m: [0.14, 0.1, 0.5], to_m: [0.14, 0.1, 0.7], target_m: [0.14, 0.1, 0]");
  spill(root() / "flat.yaml", replaced(flat, "jitter: {target_m: 0.02, roll_deg: 20}\n", ""));
  ASSERT_EQ(run("render " + path("flat.yaml") + " --views 4 --out " + path("flat")).exit_code, 0);
  const std::string out = path("flat_camera.yaml");
  const Outcome outcome =
      run("calibrate " + path("flat") + " --model f --sigma-px 0.2 --json --out " + out +
          " --observations " + path("flat/observations_exact.csv"));
  EXPECT_EQ(outcome.exit_code, 3) << outcome.out << outcome.err;
  const Json json = Json::parse(outcome.out);
  EXPECT_EQ(json["status"], "focal_not_observable");
  EXPECT_TRUE(json["camera"]["fx"].is_null());
  EXPECT_TRUE(json["camera"]["fy"].is_null());
  EXPECT_TRUE(json["sigma"]["fx"].is_null());
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(Cli, ValidateFailsWhereNothingCanBeCompared) {
  const std::string camera = path("folded.yaml");
  spill(camera,
        "image_width: 640\nimage_height: 400\n"
        "camera_matrix: {rows: 3, cols: 3, dt: d, data: [520, 0, 317, 0, 520, 203, 0, 0, 1]}\n"
        "distortion_coefficients: {rows: 1, cols: 5, dt: d, data: [-5000, 0, 0, 0, 0]}\n");
  const std::string arguments =
      " --dataset " + path("set") + " --observations " + path("set/observations_exact.csv");
  const Outcome outcome = run("validate " + camera + arguments + " --json");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.out << outcome.err;
  EXPECT_EQ(Json::parse(outcome.out)["passed"], false);
  spill(camera, replaced(slurp(camera), "image_width: 640", "image_width: 800"));
  expect_bad_input("validate " + camera + arguments, {"folded.yaml", "640x400", "800x400"});
  expect_bad_input("validate " + path("none.yaml") + arguments, {"none.yaml"});
}

TEST_F(Cli, ABoardIsTrueToScale) {
  const std::string svg = path("board.svg");
  ASSERT_EQ(run("board " + path("set/target.yaml") + " --out " + svg).exit_code, 0);
  // 4 tags of 60 mm with 3 gaps of 18 mm, and two margins of 2 cells of 7.5 mm.
  EXPECT_HAS(slurp(svg), "width=\"324.0000mm\"");
  const std::string png = path("board.png");
  ASSERT_EQ(run("board " + path("set/target.yaml") + " --dpi 127 --out " + png).exit_code, 0);
  // The file states its resolution: 5000 pixels per metre in both directions.
  EXPECT_HAS(slurp(png), std::string("pHYs\0\0\x13\x88\0\0\x13\x88\x01", 13));
  const Outcome found = run("detect --target " + path("set/target.yaml") + " " + png);
  EXPECT_EQ(std::count(found.out.begin(), found.out.end(), '\n'), 1 + 12 * 4) << found.err;
  // Corner 0 of tag 0: 15 mm from the left, and 5 pixels a mm.
  const std::size_t at = found.out.find("board.png,0,0,");
  ASSERT_NE(at, std::string::npos);
  EXPECT_NEAR(std::stod(found.out.substr(at + 14)), 15 * 5 - 0.5, 0.3);
  expect_bad_input("board " + path("set/target.yaml") + " --out " + path("board.gif"),
                   {"board.gif", ".svg"});
  expect_bad_input("board " + path("set/target.yaml") + " --dpi -1 --out " + png, {"--dpi", "-1"});
  expect_bad_input("board " + path("set/target.yaml") + " --dpi 1e7 --out " + png,
                   {"--dpi", "megapixels"});
  expect_bad_input("board " + path("set/target.yaml") + " --out " + path("no/board.svg"),
                   {"no/board.svg"});
}

}  // namespace
}  // namespace tagcal::tools
