#include "page_data.hpp"
#include "tagcal/io/image_file.hpp"

// `tagcal report` and `calibrate --report`: the data in the page.

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

class CliReport : public Cli {
 protected:
  static std::string page(const std::string& name) { return slurp(root() / name); }

  // The data of a page that a command wrote.
  static Json data_of(const std::string& arguments, const std::string& name = "page.html") {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.err;
    const Json json = data_of_page(root() / name);
    EXPECT_EQ(json["format"], 1);
    return json;
  }

  // The calibration of the exact corners, and its page.
  static Json calibrated(const std::string& set) {
    spill(exact_set(set) / "dataset.yaml",
          "image_size: [640, 400]\ntarget: target.yaml\nobservations: observations_exact.csv\n"
          "images: images\ntruth: truth.yaml\n");
    return data_of("calibrate " + path(set) + " --sigma-px 0.1 --out " + path("camera.yaml") +
                   " --report " + path("page.html"));
  }

  static std::string report(const std::string& arguments) {
    return "report " + arguments + " --out " + path("page.html");
  }

  static std::string notes_of(const Json& data) { return data["notes"].dump(); }
};

TEST_F(CliReport, ShowsWhatCalibrateFound) {
  const Json data = calibrated("set_report");
  const Json answer =
      Json::parse(run("calibrate " + path("set_report") + " --sigma-px 0.1 --json").out);
  EXPECT_EQ(data["kind"], "calibration");
  EXPECT_EQ(data["verdict"]["level"], answer["warnings"].empty() ? "ok" : "warnings");
  EXPECT_EQ(data["model"], answer["model"]);
  EXPECT_TRUE(data["chosen"]);
  EXPECT_EQ(data["num_corners"], answer["num_corners"]);
  const std::size_t corners = data["corners"]["u"].size();
  EXPECT_EQ(corners,
            answer["num_corners"].get<std::size_t>() + answer["num_outliers"].get<std::size_t>());
  for (const auto& [name, column] : data["corners"].items())
    EXPECT_EQ(column.size(), corners) << name;
  ASSERT_EQ(data["views"].size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const Json& view = data["views"][i];
    EXPECT_NEAR(view["rms_px"], answer["views"][i]["rms_px"], 1e-4);
    EXPECT_TRUE(view["thumbnail"].get<std::string>().starts_with("data:image/jpeg;base64,/9j/"));
    EXPECT_EQ(view["thumbnail_size"], Json({480, 300}));
  }
  EXPECT_EQ(data["ladder"].size(), answer["steps"].size());
  EXPECT_EQ(data["projection"].size(), 2u);  // near and infinitely far
  EXPECT_EQ(data["projection"].back()["distance_m"], Json());
  EXPECT_EQ(data["boards"][0]["squares"].size(), 12u);
  EXPECT_EQ(data["advice"]["outline_px"].size(), 48u);
  EXPECT_GE(data["formats"].size(), 4u);
  EXPECT_FALSE(data["halves"].is_null());
  EXPECT_HAS(data["made_by"]["command"].get<std::string>(), "--report");
}

// Of a bent board, with row terms: residuals without them are five times as large.
TEST_F(CliReport, ResidualsAreThoseOfTheAnswer) {
  const std::string calibrate =
      "calibrate " TAGCAL_SOURCE_DIR "/tests/data/real_corners/euroc_cam0 --report ";
  const Json data = data_of(calibrate + path("page.html"));
  const Json answer = Json::parse(
      run("calibrate " TAGCAL_SOURCE_DIR "/tests/data/real_corners/euroc_cam0 --json").out);
  EXPECT_NEAR(data["rms_px"], answer["rms_px"], 1e-3 * answer["rms_px"].get<double>());
  for (std::size_t i = 0; i < answer["views"].size(); ++i)
    EXPECT_NEAR(data["views"][i]["rms_px"], answer["views"][i]["rms_px"],
                1e-3 * answer["views"][i]["rms_px"].get<double>())
        << i;
}

TEST_F(CliReport, EstimatesTheViewsOfACameraFromAFile) {
  const Json made = calibrated("set_file");
  const Json data = data_of(report(path("camera.yaml") + " --dataset " + path("set_file")));
  EXPECT_EQ(data["model"], made["model"]);
  ASSERT_FALSE(made["findings"].empty());  // the set has few views
  EXPECT_EQ(data["findings"], made["findings"]);
  EXPECT_EQ(made["title"], "set_file: " + made["model"].get<std::string>());
  EXPECT_EQ(data["title"], "camera.yaml: " + made["model"].get<std::string>());
  EXPECT_EQ(data["num_corners"], made["num_corners"]);
  EXPECT_NEAR(data["rms_px"], made["rms_px"], 1e-3);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(data["views"][i]["camera_from_world"][2][3],
                made["views"][i]["camera_from_world"][2][3], 1e-3);
  EXPECT_EQ(data["ladder"].size(), 0u);
  EXPECT_HAS(notes_of(data), "no model ladder");
}

TEST_F(CliReport, ShowsTheCameraOfAnotherProgram) {
  calibrated("set_ros");
  good_run("convert " + path("camera.yaml") + " " + path("ros.yaml") + " --to ros");
  const Json data = data_of(report(path("ros.yaml") + " --dataset " + path("set_ros")));
  EXPECT_EQ(data["views"].size(), 6u);
  EXPECT_TRUE(data["projection"].empty());
  EXPECT_TRUE(data["parameters"][0]["sigma"].is_null());
  EXPECT_HAS(notes_of(data), "no covariance");
}

TEST_F(CliReport, ShowsACameraWithoutViews) {
  calibrated("set_bare");
  const Json data = data_of(report(path("camera.yaml")));
  EXPECT_TRUE(data["views"].empty());
  EXPECT_TRUE(data["rms_px"].is_null());
  EXPECT_HAS(notes_of(data), "no data set was given");
}

// A calibration with a covariance, and pictures of which none shows the target.
TEST_F(CliReport, ShowsPicturesWithoutTheTarget) {
  calibrated("seen");
  spill(root() / "other.yaml",
        replaced(slurp(root() / "set/target.yaml"), "first_id: 0", "first_id: 100"));
  const Json data = data_of(report(path("camera.yaml") + " --target " + path("other.yaml") + " " +
                                   path("set/images/000.png")));
  EXPECT_TRUE(data["views"].empty() || data["views"][0]["camera_from_world"].is_null()) << data;
}

TEST_F(CliReport, NamesPicturesThatItCannotShow) {
  calibrated("set_missing");
  fs::remove(root() / "set_missing/images/002.png");
  const Json data = data_of(report(path("camera.yaml") + " --dataset " + path("set_missing")));
  ASSERT_EQ(data["views"].size(), 6u);
  EXPECT_TRUE(data["views"][2]["thumbnail"].is_null());
  EXPECT_EQ(data["views"][2]["status"], "ok");
  EXPECT_HAS(notes_of(data), "1 of 6 (002.png)");
}

TEST_F(CliReport, TakesTheOptionsOfPictures) {
  calibrated("set_options");
  const std::string pictures = "--target " + path("set_options/target.yaml") + " " +
                               path("set_options/images") + " --exclude 000.png";
  const Json data = data_of(report(path("camera.yaml") + " " + pictures + " --refinement edges"));
  EXPECT_EQ(data["views"].size(), 5u);
  expect_bad_input(report(path("camera.yaml") + " --exclude 000.png"), {"--exclude", "--dataset"});
  expect_bad_input(report(path("camera.yaml") + " --frames every:3"), {"--frames", "--dataset"});
}

std::string from_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned value = 0;
  for (std::size_t i = 0; i < text.size() && text[i] != '='; ++i) {
    value = value << 6 | static_cast<unsigned>(digits.find(text[i]));
    if (i % 4 != 0) bytes += static_cast<char>(value >> (6 - 2 * (i % 4)) & 255);
  }
  return bytes;
}

// A colour picture with sixteen bits keeps its colours, however dark it is stored.
TEST_F(CliReport, ShowsDeepColours) {
  calibrated("set_deep");
  const fs::path picture = root() / "set_deep/images/000.png";
  write_png(picture, ImageRgb16({640, 400}, Rgb16{4000, 400, 400}));
  const Json data = data_of(report(path("camera.yaml") + " --dataset " + path("set_deep")));
  const std::string uri = data["views"][0]["thumbnail"];
  spill(root() / "deep.jpg", from_base64(uri.substr(uri.find(',') + 1)));
  const Picture shown = read_picture(root() / "deep.jpg");
  ASSERT_TRUE(std::holds_alternative<ImageRgb>(shown));
  const Rgb colour = std::get<ImageRgb>(shown)(100, 100);
  EXPECT_GT(colour[0], 200);
  EXPECT_LT(colour[1], 60);
}

TEST_F(CliReport, EscapesTheNamesOfPictures) {
  calibrated("set_script");
  const fs::path set = root() / "set_script";
  const std::string name = "<script>alert(1)<-script>@JS@.png";
  fs::rename(set / "images/000.png", set / "images" / name);
  std::string csv = slurp(set / "observations_exact.csv");
  for (std::size_t at; (at = csv.find("000.png")) != std::string::npos;) csv.replace(at, 7, name);
  spill(set / "observations_exact.csv", csv);
  fs::remove(set / "truth.yaml");
  spill(set / "dataset.yaml",
        "image_size: [640, 400]\ntarget: target.yaml\nobservations: observations_exact.csv\n"
        "images: images\n");
  const Json data = data_of(report(path("camera.yaml") + " --dataset " + path("set_script")));
  EXPECT_EQ(data["views"][0]["image"], name);
  EXPECT_LACKS(page("page.html"), "<script>alert");
  EXPECT_FALSE(data["views"][0]["thumbnail"].is_null());
}

TEST_F(CliReport, ShowsWhyThereIsNoAnswer) {
  const fs::path set = exact_set("set_none");
  const std::string csv = slurp(set / "observations_exact.csv");
  spill(set / "observations_exact.csv",
        csv.substr(0, csv.find("000.png,3,")));  // three tags of a view
  const Outcome outcome =
      run("calibrate " + path("set_none") + " --model opencv8 --sigma-px 1 --out " +
          path("none.yaml") + " --report " + path("page.html"));
  ASSERT_EQ(outcome.exit_code, 3) << outcome.out;
  const std::string text = page("page.html");
  EXPECT_HAS(text, R"("level":"no_answer","sentence":"NO ANSWER: )");
  EXPECT_HAS(text, R"("severity":"error")");
  EXPECT_LACKS(text, R"("du":[0)");
}

TEST_F(CliReport, ComparesTwoCalibrations) {
  calibrated("set_two");
  const std::string other = replaced(slurp(root() / "camera.yaml"), "model: ", "model:  ");
  spill(root() / "other.yaml", other);
  const Json same = data_of(report(path("camera.yaml") + " " + path("other.yaml")));
  EXPECT_EQ(same["kind"], "difference");
  EXPECT_EQ(same["title"], "camera.yaml and other.yaml");
  EXPECT_EQ(same["verdict"]["level"], "warnings");  // their standard deviations are large
  EXPECT_TRUE(same["verdict"]["sentence"].get<std::string>().starts_with("CANNOT TELL: "));
  ASSERT_EQ(same["difference"]["maps"].size(), 2u);
  EXPECT_GT(same["difference"]["maps"][0]["p_value"], 0.5);
  EXPECT_EQ(same["difference"]["parameters"][0]["in_sigmas"], 0);
}

TEST_F(CliReport, ShowsPoses) {
  calibrated("set_poses");
  spill(root() / "set_poses/dataset.yaml",
        "image_size: [640, 400]\ntarget:\n  - {file: target.yaml, world_from_board: {rotation: [1, "
        "0, "
        "0, 0], translation_m: [0.3, 0.2, 0.1]}}\n"
        "observations: observations_exact.csv\nimages: images\n");
  const Outcome poses =
      run("pose " + path("set_poses") + " --camera " + path("camera.yaml") + " --json");
  spill(root() / "poses.json", poses.out);
  const Json data = data_of(report(path("poses.json") + " --dataset " + path("set_poses") +
                                   " --camera " + path("camera.yaml")));
  EXPECT_EQ(data["kind"], "poses");
  ASSERT_EQ(data["views"].size(), 6u);
  EXPECT_EQ(data["views"][0]["hypotheses"].size(), 1u);
  for (const char* name : {"du", "dv"})
    for (const Json& residual : data["corners"][name])
      EXPECT_LT(std::abs(residual.get<double>()), 1);
  EXPECT_EQ(data_of(report(path("poses.json")))["views"].size(), 6u);
  spill(root() / "wrong.yaml",
        replaced(slurp(root() / "set/target.yaml"), "tagSpacing: 0.3", "tagSpacing: 0.2"));
  const Outcome wrong = good_run(
      report(path("poses.json") + " --target " + path("wrong.yaml") + " " + path("set/images")));
  EXPECT_HAS(wrong.err, "wrong tag spacing");
}

TEST_F(CliReport, NamesTheValueOfPosesThatIsWrong) {
  const std::string good =
      R"({"views": [{"image": "a.png", "status": "ok", "rms_px": 0.1, "num_corners": 4,
 "probability": 1, "outliers": [{"tag_id": 1, "corner": 2}], "alternative": null,
 "findings": [{"code": "c", "severity": "warning", "sentence": "S."}],
 "camera_from_board": {"rotation": [1, 0, 0, 0], "translation_m": [0, 0, 1]}}]})";
  spill(root() / "good.json", good);
  EXPECT_EQ(data_of(report(path("good.json")))["views"][0]["num_rejected"], 1);
  const std::vector<std::vector<std::string>> changes = {
      {"[1, 0, 0, 0]", "[2, 0, 0, 0]", "rotation: must be a unit quaternion", "length 2"},
      {"[1, 0, 0, 0]", "[0, 0, 0, 0]", "rotation: must be a unit quaternion", "length 0"},
      {"[1, 0, 0, 0]", "[1e300, 0, 0, 0]", "rotation: must be a unit quaternion", "length inf"},
      {"[1, 0, 0, 0]", "[1]", "rotation: must be a list of 4"},
      {"[0, 0, 1]", "[0, 0, NaN]", "translation_m[2]: must be a finite number, got NaN"},
      {"[0, 0, 1]", "[0, 0, 1e999]", "translation_m[2]: must be a finite number, got 1e999"},
      {R"(, "translation_m")", R"(, "t")", "camera_from_board.translation_m: the key is missing"},
      {R"("ok")", R"("banana")", "status: must be ok, ambiguous", R"(got "banana")"},
      {R"("image")", R"("picture")", "views[0].image: the key is missing"},
      {"0.1", "-5", "rms_px: must be from 0", "got -5"},
      {R"("tag_id": 1)", R"("tag_id": "x")", "outliers[0].tag_id: must be a whole number"},
      {R"("warning")", R"("bad")", "findings[0].severity: must be note, warning, refusal"}};
  for (const std::vector<std::string>& change : changes) {
    spill(root() / "bad.json", replaced(good, change[0], change[1]));
    expect_bad_input("report " + path("bad.json") + " --out " + path("new.html"),
                     {"bad.json: views[0].", change[2], change.back()});
  }
}

TEST_F(CliReport, RefusesBadFilesBeforeAnyWork) {
  calibrated("set_bad");
  const auto before = names();
  expect_bad_input("report " + path("camera.yaml") + " --out " + path("none/page.html"),
                   {"none/page.html", "cannot be written"});
  expect_bad_input("report " + path("camera.yaml") + " --out " + path("camera.yaml"),
                   {"camera.yaml", "is an input"});
  spill(root() / "set_bad/notes.txt", "mine");
  expect_bad_input("report " + path("camera.yaml") + " --out " + path("set_bad/notes.txt"),
                   {"notes.txt", "is no HTML page"});
  EXPECT_EQ(slurp(root() / "set_bad/notes.txt"), "mine");
  spill(root() / "set_bad/poses.json", R"({"views": [{"image": "a.png", "status": 3}]})");
  expect_bad_input("report " + path("set_bad/poses.json") + " --out " + path("new.html"),
                   {"poses.json: views[0].status: must be ok, ambiguous", ", got 3"});
  expect_bad_input("report " + path("nothing.yaml") + " --out " + path("new.html"),
                   {"nothing.yaml"});
  expect_bad_input("report " + path("camera.yaml") + " --out " + path("new.html") +
                       " --observations " + path("c.csv"),
                   {"--observations", "--dataset"});
  expect_bad_input("calibrate " + path("set_bad") + " --report " + path("none/page.html"),
                   {"none/page.html", "cannot be written"});
  EXPECT_EQ(names(), before);
}

}  // namespace
}  // namespace tagcal::tools
