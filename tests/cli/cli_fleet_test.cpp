#include <iomanip>
#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"
#include "tagcal/random.hpp"

// The table of a fleet. Its units are summaries of one calibration with other values.

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

class CliFleet : public Cli {
 protected:
  static void SetUpTestSuite() {
    Cli::SetUpTestSuite();
    exact_set("one");
    exact_set("two");
    good_run("calibrate " + path("one") + " " + path("two") + " --model f+c --sigma-px 0.2" +
             " --out " + path("real"));
  }

  // Numbers with blanks between them, each by a function of it and its place.
  static std::string changed(const std::string& numbers,
                             const std::function<double(double, std::size_t)>& change) {
    std::istringstream words(numbers);
    std::string text;
    std::size_t j = 0;
    for (double value; words >> value; ++j) {
      std::ostringstream word;
      word << std::setprecision(17) << change(value, j);
      text += (j > 0 ? " " : "") + word.str();
    }
    return text;
  }

  // A unit with f, cx, cy off those of the calibration by some numbers of px, and a hundredth of
  // its standard deviations: 0.2 px of f.
  static void put(const std::string& folder, const std::string& name, double f, double cx,
                  double cy, const std::function<void(Json&)>& change = {}) {
    Json summary = Json::parse(slurp(path("real/summary/one.json")));
    const double by[] = {f, cx, cy};
    summary["unit"]["values"] = changed(summary["unit"]["values"],
                                        [&](double value, std::size_t j) { return value + by[j]; });
    summary["unit"]["covariance"] = changed(
        summary["unit"]["covariance"], [](double element, std::size_t) { return 1e-4 * element; });
    if (change) change(summary);
    spill(root() / folder / "summary" / (name + ".json"), summary.dump());
    fs::copy_file(path("real/one.yaml"), root() / folder / (name + ".yaml"),
                  fs::copy_options::skip_existing);
  }

  // Fifty units with spreads of 4, 2 and 1 px.
  static std::string fleet(const std::string& folder) {
    Random random(3);
    for (int i = 0; i < 50; ++i)
      put(folder, "cam" + std::to_string(100 + i), 4 * random.normal(), 2 * random.normal(),
          random.normal());
    return "fleet " + path(folder);
  }

  static Json json_of(const std::string& command) {
    return Json::parse(run(command + " --json").out);
  }
  static Json unit(const Json& fleet, const std::string& name) {
    for (const Json& one : fleet["units"])
      if (one["name"] == name) return one;
    ADD_FAILURE() << name;
    return {};
  }
};

TEST_F(CliFleet, ReadsWhatCalibrateWrites) {
  const Json fleet = json_of("fleet " + path("real"));
  EXPECT_EQ(unit(fleet, "one")["status"], "ok");
  EXPECT_EQ(unit(fleet, "one")["verdict"], "not_judged");
  EXPECT_EQ(fleet["groups"][0]["findings"][0]["code"], "few_units");
  EXPECT_EQ(run("fleet " + path("real")).exit_code, 3);
  const Json calibration = json_of("calibrate " + path("one") + " --model f+c --sigma-px 0.2");
  EXPECT_DOUBLE_EQ(unit(fleet, "one")["values"][0], calibration["camera"]["fx"]);
  EXPECT_NEAR(unit(fleet, "one")["sigmas"][0], calibration["sigma"]["fx"].get<double>(), 1e-9);
}

TEST_F(CliFleet, NamesTheUnitThatIsUnlikeTheOthers) {
  const std::string command = fleet("usual");
  const Outcome good = run(command);
  EXPECT_EQ(good.exit_code, 0) << good.out << good.err;
  EXPECT_TRUE(good.out.starts_with("50 sets: 50 ok; 0 outlying (p < 1e-04, 0.0 by chance)"))
      << good.out;
  put("usual", "odd", 0, 20, 0);
  put("usual", "unseen", 0, 0, 0, [](Json& summary) {
    summary["unit"] = {{"status", "degenerate"},
                       {"reason", "no picture shows the target"},
                       {"lens", ""},
                       {"model", ""},
                       {"names", ""},
                       {"image_size", {0, 0}},
                       {"rms_px", 0},
                       {"values", ""},
                       {"covariance", ""}};
  });
  const Outcome bad = run(command + " --out " + path("usual.csv"));
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_TRUE(
      bad.out.starts_with("52 sets: 51 ok, 1 degenerate; 1 outlying (p < 1e-04, 0.0 by "
                          "chance): odd cx +"))
      << bad.out;
  const std::string csv = slurp(root() / "usual.csv");
  EXPECT_TRUE(
      csv.starts_with("name,serial,date,temperature_c,status,verdict,reason,"
                      "squared_distance,p_value,displacement_px,f,sd_f,cx,sd_cx,cy,"
                      "sd_cy\n"))
      << csv.substr(0, 200);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 53);
  const Json fleet = json_of(command);
  EXPECT_EQ(fleet["worst"][0], "odd");
  EXPECT_EQ(unit(fleet, "odd")["most"], "cx");
  EXPECT_NEAR(unit(fleet, "odd")["displacement_px"], 20, 3);
  EXPECT_EQ(unit(fleet, "unseen")["verdict"], "no_answer");
  const Json& group = fleet["groups"][0];
  const double spreads[] = {4, 2, 1};
  for (std::size_t j = 0; j < 3; ++j)
    EXPECT_NEAR(group["spread"][j], spreads[j], 4 * group["sigma_spread"][j].get<double>());
  // f is 4 px of 520 at a third of the image, and less in the middle.
  EXPECT_NEAR(group["spread_px"], 2, 1);
}

TEST_F(CliFleet, JudgesByLimits) {
  const std::string command = fleet("limited") + " --limits " + path("limits.yaml");
  put("limited", "odd", 0, 20, 0);
  spill(root() / "limits.yaml", "parameters: {f: [490, 550]}\nrms_px: 1\n");
  const Outcome good = run(command);
  EXPECT_EQ(good.exit_code, 0) << good.out;
  EXPECT_TRUE(good.out.starts_with("51 sets: 51 ok\n")) << good.out;
  EXPECT_EQ(json_of(command)["worst"][0], "odd");
  spill(root() / "limits.yaml", "parameters: {cx: [300, 330]}\n");
  EXPECT_EQ(run(command).exit_code, 1);
  EXPECT_HAS(run(command).out, "1 out_of_limits: odd cx 33");
  spill(root() / "limits.yaml", "displacement_px: 15\n");
  EXPECT_HAS(run(command).out, "1 out_of_limits: odd displacement_px");
  for (const auto& [text, part] :
       {std::pair("parameters: {fz: [1, 2]}\n", "fz is no parameter of these units (f, cx, cy)"),
        std::pair("parameters: {f: [2, 1]}\n", "must not be above the second"),
        std::pair("parameters: {f: 3}\n", "parameters.f"), std::pair("rms: 3\n", "rms"),
        std::pair("rms_px: -1\n", "rms_px")}) {
    spill(root() / "limits.yaml", text);
    expect_bad_input(command, {part});
  }
}

// By its names, cam_2026-01-01 to cam_2026-06-01.
TEST_F(CliFleet, FindsTheSerialThatDrifts) {
  const std::string command = fleet("dated") + " --history";
  Random random(4);
  for (int month = 1; month <= 6; ++month)
    for (int i = 0; i < 12; ++i)
      put("dated", "old" + std::to_string(i) + "_2026-0" + std::to_string(month) + "-01",
          (i == 5 ? 0.4 * month : 0) + 0.001 * random.normal(), 0.001 * random.normal(),
          0.001 * random.normal());
  const Outcome outcome = run(command);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_HAS(outcome.out, "; 1 drifted: old5_2026-06-01 f +4.");
  const Json fleet = json_of(command);
  EXPECT_EQ(fleet["drifts"].size(), 12u);
  EXPECT_EQ(unit(fleet, "old5_2026-05-01")["verdict"], "earlier");
  EXPECT_EQ(unit(fleet, "old5_2026-05-01")["serial"], "old5");
  EXPECT_EQ(unit(fleet, "old4_2026-06-01")["verdict"], "ok");
  for (const Json& drift : fleet["drifts"])
    EXPECT_EQ(drift["p_days"].get<double>() < 1e-4, drift["serial"] == "old5") << drift;
  EXPECT_EQ(fleet["groups"][0]["num_units"], 62);
}

TEST_F(CliFleet, TakesSerialsDatesAndTemperaturesFromATable) {
  const std::string command = fleet("listed") + " --units " + path("units.csv");
  spill(root() / "units.csv",
        "name,serial,date,temperature_c\ncam100,left,2026-03-01,20\ncam101,left,2026-04-01,30\n"
        "cam102,left,2026-05-01,25\ncam103,right,,\n");
  const Json fleet = json_of(command + " --history");
  EXPECT_EQ(unit(fleet, "cam101")["temperature_c"], 30);
  EXPECT_EQ(unit(fleet, "cam101")["verdict"], "earlier");
  EXPECT_EQ(unit(fleet, "cam103")["serial"], "right");
  EXPECT_TRUE(unit(fleet, "cam103")["date"].is_null());
  ASSERT_EQ(fleet["drifts"].size(), 1u);
  EXPECT_EQ(fleet["drifts"][0]["covariates"], Json({"days", "temperature_c"}));
  const std::string head = "name,serial,date,temperature_c\n";
  for (const auto& [text, parts] : std::map<std::string, std::vector<std::string>>{
           {head + "cam1,a,2026-03-01,\n", {"units.csv", "line 2", "calibration of the folder"}},
           {head + "cam100,a,2026-13-01,\n", {"line 2", "date", "2026-13-01"}},
           {head + "cam100,a,,warm\n", {"line 2", "temperature_c"}},
           {head + "cam100,a,,\ncam100,a,,\n", {"line 3", "given once"}},
           {"name,owner\ncam100,me\n", {"owner", "no column"}},
           {"serial\na\n", {"name"}}}) {
    spill(root() / "units.csv", text);
    expect_bad_input(command, parts);
  }
}

TEST_F(CliFleet, ListsWhatItDoesNotJudge) {
  const std::string command = fleet("various");
  put("various", "gone", 0, 0, 0);
  fs::remove(path("various/gone.yaml"));
  put("various", "twin_2026-01-02", 0, 0, 0, [](Json&) {});
  put("various", "twin-2026-01-02", 0, 0, 0, [](Json&) {});
  spill(root() / "various/summary/torn.json", "{\"unit\": {");
  spill(root() / "various/notes.yaml", "colour: red\n");
  good_run("convert " + path("real/one.yaml") + " " + path("various/foreign.yaml") +
           " --to kalibr");
  const Outcome outcome = run(command);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;  // the damaged summary
  EXPECT_HAS(outcome.err, "warning: no calibration: ");
  EXPECT_HAS(outcome.err, "2 calibrations of twin have the date 2026-01-02");
  EXPECT_HAS(outcome.out, "; 4 not judged");
  const Json fleet = json_of(command);
  EXPECT_EQ(unit(fleet, "foreign")["reason"], "has no covariance");
  EXPECT_EQ(unit(fleet, "gone")["reason"], "gone.yaml is missing");
  EXPECT_EQ(unit(fleet, "torn")["status"], "error");
  EXPECT_EQ(unit(fleet, "twin_2026-01-02")["verdict"], "not_judged");
}

TEST_F(CliFleet, ComparesModelsAndSizesApartAndSaysSo) {
  const std::string command = fleet("mixed");
  put("mixed", "small", 0, 0, 0, [](Json& summary) { summary["unit"]["image_size"] = {320, 200}; });
  put("mixed", "other", 0, 0, 0, [](Json& summary) { summary["made_by"] = "tagcal 0 --model f"; });
  const Outcome outcome = run(command);
  EXPECT_HAS(outcome.err, "compared apart: f+c 640x400 (51), f+c 320x200 (1)");
  EXPECT_HAS(outcome.err, "made with 2 different options or versions");
  EXPECT_EQ(json_of(command)["groups"].size(), 2u);
}

TEST_F(CliFleet, RefusesWhatIsNoFleet) {
  fs::create_directories(path("empty"));
  expect_bad_input("fleet " + path("empty"), {"has no calibrations", "tagcal calibrate"});
  expect_bad_input("fleet " + path("nowhere"), {"nowhere", "must be the folder"});
  expect_bad_input("fleet " + path("scene.yaml"), {"must be the folder"});
  expect_bad_input(fleet("named") + " --out " + path("x.txt"), {".csv, .json or .html"});
  spill(root() / "words/notes.yaml", "a: 1\n");
  expect_bad_input("fleet " + path("words"), {"has no calibrations"});
}

}  // namespace
}  // namespace tagcal::tools
