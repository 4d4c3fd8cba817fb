#include <nlohmann/json.hpp>
#include <set>

#include "cli_fixture.hpp"
#include "png_colours.hpp"

// `calibrate` and `diff` from outside: uncertainty, findings, rejected corners, comparison.

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

TEST_F(Cli, AutoExplainsEveryStep) {
  const std::string set =
      "calibrate " + path("set") + " --observations " + path("set/observations_exact.csv");
  const Outcome text = run(set + " --verbose");
  ASSERT_EQ(text.exit_code, 0) << text.out << text.err;
  EXPECT_TRUE(text.out.starts_with("OK, 1 warning: radial1 (chosen), ")) << text.out;
  EXPECT_HAS(text.out, "+ radial1 ");
  EXPECT_HAS(text.out, "- opencv8 ");
  const Json json = Json::parse(run(set + " --json --advise").out);
  ASSERT_EQ(json["steps"].size(), 10u);
  EXPECT_EQ(json["steps"][0]["model"], "weak");
  EXPECT_EQ(json["steps"][4]["model"], "radial1");
  EXPECT_EQ(json["steps"][4]["taken"], true);
  EXPECT_EQ(json["steps"][8]["taken"], false);
  EXPECT_GT(json["advice"]["focal_sigma_now_px"], json["advice"]["focal_sigma_px"]);
  EXPECT_FALSE(json["advice"]["sentence"].get<std::string>().empty());
  EXPECT_EQ(json["board_warp"].size(), 6u);
  ASSERT_EQ(json["projection"].size(), 2u);
  EXPECT_EQ(json["projection"][0]["distance_m"], "infinity");
  EXPECT_LE(json["projection"][0]["rms_px"], json["projection"][0]["max_px"]);
  EXPECT_LE(json["projection"][0]["max_px"], json["projection"][0]["whole_image_max_px"]);
}

// Frontal views of a board: each has its scale, and there is no focal length.
TEST_F(Cli, WithoutAFocalLengthTheModelIsWeak) {
  const std::string flat = replaced(
      kScene,
      "type: dome, target_m: [0.14, 0.1, 0], min_distance_m: 0.45, "
      "max_distance_m: 0.6, min_elevation_deg: 45, max_elevation_deg: 80",
      "type: line, from_m: [0.14, 0.1, 0.5], to_m: [0.14, 0.1, 0.7], target_m: [0.14, 0.1, 0]");
  const std::string straight = replaced(flat, "jitter: {target_m: 0.02, roll_deg: 20}\n", "");
  spill(root() / "straight.yaml",
        replaced(straight, "radial1, f: 520, cx: 317, cy: 203, distortion: [-0.1]", "f, f: 520"));
  good_run("render " + path("straight.yaml") + " --views 4 --out " + path("straight"));
  const std::string set = "calibrate " + path("straight") +
                          " --sigma-px 0.2 --advise --observations " +
                          path("straight/observations_exact.csv");
  const Outcome outcome = run(set + " --json --out " + path("straight_camera.yaml"));
  EXPECT_EQ(outcome.exit_code, 3) << outcome.out << outcome.err;
  const Json json = Json::parse(outcome.out);
  EXPECT_EQ(json["status"], "focal_not_observable");
  EXPECT_EQ(json["model"], "weak");
  EXPECT_TRUE(json["camera"]["fx"].is_null());
  EXPECT_TRUE(json["camera"]["fy"].is_null());
  EXPECT_EQ(json["camera"]["cx"], 319.5);
  EXPECT_EQ(json["steps"][0]["taken"], true);
  EXPECT_FALSE(json["advice"]["sentence"].get<std::string>().empty());
  EXPECT_TRUE(json["advice"]["focal_sigma_now_px"].is_null());
  EXPECT_FALSE(fs::exists(path("straight_camera.yaml")));
  EXPECT_TRUE(run(set).out.starts_with("NO ANSWER: the views do not determine the focal length"));
}

TEST_F(Cli, WeakIsAnAnswerWhereItIsAskedFor) {
  const std::string exact = "calibrate " + exact_set("exact").string() + " --model ";
  const std::string set = exact + "weak";
  const Outcome outcome = run(set + " --json --out " + path("weak.yaml"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  const Json json = Json::parse(outcome.out);
  EXPECT_EQ(json["status"], "ok");
  EXPECT_EQ(json["model"], "weak");
  EXPECT_TRUE(json["camera"]["fx"].is_null());
  EXPECT_TRUE(json["sigma"]["fy"].is_null());
  EXPECT_EQ(json["camera"]["cx"], 319.5);
  EXPECT_HAS(json["warnings"].back().get<std::string>(), "show perspective");
  ASSERT_EQ(json["views"].size(), 6u);
  for (const Json& view : json["views"]) {
    EXPECT_NEAR(view["scale_px_per_m"].get<double>(), 1000, 250);  // f 520 px at 0.45 to 0.6 m
    EXPECT_GT(view["scale_sigma_px_per_m"].get<double>(), 0);
    EXPECT_EQ(view["translation_m"][2], 0);
    EXPECT_EQ(view["mirrored"]["translation_m"].size(), 3u);
    EXPECT_GT(view["covariance"][0][0].get<double>(), 0);
    EXPECT_TRUE(view["covariance"][5][5].is_null());
  }
  const std::string file = slurp(path("weak.yaml"));
  EXPECT_LACKS(file, "camera_matrix");
  EXPECT_HAS(file, "model: \"weak\"");
  EXPECT_HAS(file, "     scale_px_per_m: ");
  EXPECT_HAS(file, "     mirrored_rotation: [");
  EXPECT_HAS(run(set).out, "each view its own");
  expect_bad_input("diff " + path("weak.yaml") + " " + path("weak.yaml"),
                   {"weak.yaml: model", "weak"});
  expect_bad_input(set + " --board-warp", {"--board-warp", "weak"});
  const Json views = Json::parse(run(exact + "f+c --json").out)["views"];
  ASSERT_EQ(views.size(), 6u);
  EXPECT_FALSE(views[0].contains("scale_px_per_m"));
  EXPECT_GT(views[0]["translation_m"][2], 0.3);
}

// 6 views: tag 5 is rotated, 001 is mirrored, half a tag of 003 and a corner of 004 are
// displaced.
TEST_F(Cli, RejectedCornersAreListed) {
  const fs::path folder = exact_set("wrong");
  std::istringstream rows(slurp(folder / "observations_exact.csv"));
  std::string row, text;
  std::getline(rows, text);
  text += '\n';
  std::size_t num_wrong = 0;
  while (std::getline(rows, row)) {
    std::istringstream fields(row);
    std::string image, tag, corner, x, y;
    std::getline(fields, image, ',');
    std::getline(fields, tag, ',');
    std::getline(fields, corner, ',');
    std::getline(fields, x, ',');
    std::getline(fields, y, ',');
    const bool moved = (image == "003.png" && tag == "2" && corner <= "1") ||
                       (image == "004.png" && tag == "7" && corner == "3");
    if (moved) x = std::to_string(std::stod(x) + 25);
    if (image == "001.png") x = std::to_string(639 - std::stod(x));
    num_wrong += moved || image == "001.png" || tag == "5";
    if (tag == "5") corner = std::to_string((std::stoi(corner) + 1) % 4);
    text += image + "," + tag + "," + corner + "," + x + "," + y + "\n";
  }
  spill(folder / "observations_exact.csv", text);
  const std::string set = "calibrate " + folder.string() + " --model radial1 --sigma-px 0.1";
  const Outcome outcome = run(set + " --verbose");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  const std::string all = std::to_string(num_wrong);
  for (const std::string& line :
       {"rejected   " + all + " corners in 6 pictures\n",
        std::string("  tag 5 in 5 of 5 views, up to "), std::string("  001.png: the whole view, "),
        std::string("  003.png: 2 corners, tag 2 corner "),
        std::string("  004.png: tag 7 corner 3 (2"),
        std::string("001.png: rejected, its tags are")})
    EXPECT_HAS(outcome.out, line);
  EXPECT_LACKS(outcome.out, "  000.png: ");
  const Json json = Json::parse(run(set + " --json").out);
  EXPECT_EQ(json["num_outliers"], num_wrong);
  ASSERT_EQ(json["outliers"].size(), num_wrong);
  std::set<std::string> names;
  for (const Json& o : json["outliers"]) {
    names.insert(o["image"].get<std::string>() + o["tag_id"].dump() + o["corner"].dump());
    EXPECT_EQ(o["residual_px"].is_null(), o["image"] == "001.png");
  }
  EXPECT_EQ(names.size(), num_wrong);
  EXPECT_EQ(names.count("004.png73"), 1u);
  // The priors of lens and board move it by a small part of its standard deviation.
  EXPECT_NEAR(json["camera"]["fx"].get<double>(), 520, 0.05 * json["sigma"]["fx"].get<double>());
}

TEST_F(Cli, DrawsTheUncertainty) {
  const std::string set = "calibrate " + path("set") + " --model radial1 --uncertainty ";
  ASSERT_EQ(run(set + path("u.svg")).exit_code, 0);
  const std::string svg = slurp(path("u.svg"));
  EXPECT_HAS(svg, "<svg ");
  EXPECT_HAS(svg, "stroke-dasharray");
  const auto colours_of = [&](const std::string& options) {
    EXPECT_EQ(run(set + path("u.png") + options).exit_code, 0);
    return png_colours(path("u.png"));
  };
  const std::vector<Rgb> colours = colours_of("");
  const auto num_grey =
      std::ranges::count_if(colours, [](const Rgb& c) { return c[0] == c[1] && c[1] == c[2]; });
  EXPECT_LT(num_grey, std::ssize(colours) / 2);
  EXPECT_EQ(2 * colours_of(" --distance 3").size(), 3 * colours.size());  // a panel more
  const Json json = Json::parse(run(set + path("u.svg") + " --distance 3 --json").out);
  EXPECT_EQ(json["projection"][2]["distance_m"], 3);
  expect_bad_input("calibrate " + path("set") + " --model weak --uncertainty " + path("u.svg"),
                   {"--uncertainty", "weak"});
  expect_bad_input(set + path("u.jpg"), {"u.jpg", ".svg or .png"});
  EXPECT_FALSE(fs::exists(path("u.jpg")));
}

TEST_F(Cli, DiffOfACalibrationWithItselfIsNothing) {
  const std::string a = path("a.yaml"), b = path("b.yaml");
  ASSERT_EQ(run("calibrate " + path("set") + " --model radial1 --out " + a).exit_code, 0);
  ASSERT_EQ(run("calibrate " + path("set") + " --model f+c --out " + b).exit_code, 0);
  const Json same = Json::parse(run("diff " + a + " " + a + " --json").out);
  const Json other = Json::parse(run("diff " + a + " " + b + " --distance 0.5 --json").out);
  ASSERT_EQ(same["differences"].size(), 2u);
  for (const Json& d : same["differences"]) EXPECT_LT(d["whole_image_max_px"], 1e-6);
  EXPECT_EQ(other["differences"][0]["distance_m"], "infinity");
  EXPECT_EQ(other["differences"][1]["distance_m"], 0.5);
  for (const Json& d : other["differences"]) {
    EXPECT_GT(d["rms_px"], 0.1);  // the part of k1 = -0.1 that pose and f do not explain
    EXPECT_LE(d["rms_px"], d["max_px"]);
    EXPECT_GT(d["whole_image_max_px"], 0.3);
    EXPECT_EQ(d["difference_px"].size(), 13u);
    EXPECT_EQ(d["difference_px"][0].size(), 21u);
  }
  EXPECT_HAS(run("diff " + a + " " + b).out, "at infinity");
  EXPECT_HAS(run("diff " + a + " " + a).out, "both have the same lens");
  // With a limit it is a check.
  EXPECT_EQ(run("diff " + a + " " + b + " --limit 1e-9").exit_code, 1);
  EXPECT_EQ(run("diff " + a + " " + a + " --limit 1e-9").exit_code, 3);
  EXPECT_EQ(run("diff " + a + " " + a + " --limit 1e9").exit_code, 0);
  expect_bad_input("calibrate " + path("set") + " --out " + path("a.html"),
                   {"a.html: has the name of another kind of file"});
}

// What was found out about the pictures is in the answer, beside what was about the calibration.
TEST_F(Cli, AnAnswerNamesThePicturesWithoutABoard) {
  const fs::path folder = root() / "with-blank";
  fs::copy(root() / "set/images", folder, fs::copy_options::recursive);
  spill(folder / "blank.pgm", "P5 640 400 255\n" + std::string(640 * 400, '\x80'));
  const Outcome outcome = good_run("calibrate --target " + path("set/target.yaml") + " " +
                                   folder.string() + " --model radial1 --json");
  const Json answer = Json::parse(outcome.out);
  bool is_named = false;
  for (const Json& finding : answer["findings"])
    is_named |= finding["code"] == "input" &&
                finding["sentence"] == "blank.pgm: no tag of the boards found";
  EXPECT_TRUE(is_named) << outcome.out;
}

// A principal point moved by f tan(1 degree) is a camera turned by a degree about its y axis.
TEST_F(Cli, DiffSaysByHowManyDegreesACameraIsTurned) {
  const auto pinhole_file = [&](const std::string& name, double cx) {
    spill(path(name),
          "image_width: 640\nimage_height: 400\nmodel: pinhole\n"
          "camera_matrix: {rows: 3, cols: 3, dt: d, data: [2000, 0, " +
              std::to_string(cx) +
              ", 0, 2000, 199.5, 0, 0, 1]}\n"
              "distortion_coefficients: {rows: 1, cols: 5, dt: d, data: [0, 0, 0, 0, 0]}\n");
    return path(name);
  };
  const std::string a = pinhole_file("straight.yaml", 319.5);
  const std::string b = pinhole_file("turned.yaml", 319.5 + 2000 * std::tan(0.01745329252));
  const Json both = Json::parse(run("diff " + a + " " + b + " --json --distance 3").out);
  const Json& far = both["differences"][0];
  EXPECT_LT(far["rms_px"], 0.5);
  EXPECT_NEAR(far["rotation_deg"][0].get<double>(), 0, 0.01);
  EXPECT_NEAR(far["rotation_deg"][1].get<double>(), -1, 0.02);
  EXPECT_NEAR(far["rotation_deg"][2].get<double>(), 0, 0.01);
}

TEST_F(Cli, DiffOfWhatCannotBeComparedIsAnError) {
  const std::string a = path("d.yaml");
  ASSERT_EQ(run("calibrate " + path("set") + " --model radial1 --out " + a).exit_code, 0);
  spill(path("larger.yaml"), replaced(slurp(a), "image_width: 640", "image_width: 641"));
  expect_bad_input("diff " + a + " " + path("larger.yaml"),
                   {"larger.yaml: image size must be 640x400", "641x400"});
  expect_bad_input("diff " + a + " " + path("nowhere.yaml"), {"nowhere.yaml"});
  expect_bad_input("diff " + a, {"B"});
}

// Every calibration of one flat board has its terms; the terminal shows them if one is significant,
// or on demand.
TEST_F(Cli, TheBoardIsReportedInMillimetres) {
  const std::string set = "calibrate " + path("set") + " --model radial1";
  const Outcome outcome = run(set + " --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  const Json board = Json::parse(outcome.out)["board_warp"];
  const std::pair<Json, Json> terms[] = {{board["bend_mm"][0], board["sigma_mm"][0]},
                                         {board["bend_mm"][1], board["sigma_mm"][1]},
                                         {board["twist_mm"], board["sigma_twist_mm"]},
                                         {board["aspect"], board["sigma_aspect"]}};
  bool is_shown = false;
  for (const auto& [value, sigma] : terms) {
    EXPECT_LT(std::abs(value.get<double>()), 5 * sigma.get<double>());
    is_shown |= std::abs(value.get<double>()) > 2 * sigma.get<double>();
  }
  const std::string line = "\nboard      bent by ";
  EXPECT_EQ(run(set).out.find(line) != std::string::npos, is_shown);
  const std::string text = run(set + " --board-warp").out;
  EXPECT_HAS(text, line);
  for (const char* term : {" mm along x, ", " mm along y, ", "twisted by ", "longer along y by "})
    EXPECT_HAS(text, term);
}

}  // namespace
}  // namespace tagcal::tools
