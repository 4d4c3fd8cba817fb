#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"

// tagcal history, from outside.

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

const std::string kDeskSet = TAGCAL_SOURCE_DIR "/data-synthetic/golden/desk";

class HistoryCli : public Cli {
 protected:
  static const std::string& camera() {
    static const std::string text = [] {
      const std::string name = path("desk-camera.yaml");
      EXPECT_EQ(run("calibrate " + kDeskSet + " --model radial1 --out " + name).exit_code, 0);
      return slurp(name);
    }();
    return text;
  }

  // The camera with its principal point moved, and a line more.
  static std::string moved(const std::string& name, double px, const std::string& more = "") {
    std::string text = camera();
    const std::regex matrix("(camera_matrix:[^\\[]*\\[[^,]+, *[^,]+, *)([^,]+)");
    std::smatch match;
    EXPECT_TRUE(std::regex_search(text, match, matrix));
    const std::string cx = std::to_string(std::stod(match[2]) + px);
    text = match.prefix().str() + match[1].str() + cx + match.suffix().str() + more;
    spill(path(name), text);
    return path(name) + " ";
  }

  static Json json_of(const std::string& command, int exit_code) {
    const Outcome outcome = run(command + " --json");
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.out << outcome.err;
    return Json::parse(outcome.out);
  }
};

TEST_F(HistoryCli, TheSameCameraIsStable) {
  const std::string files = moved("a.yaml", 0) + moved("b.yaml", 0) + moved("c.yaml", 0);
  const Outcome outcome = run("history " + files);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  EXPECT_TRUE(outcome.out.starts_with("STABLE: ")) << outcome.out;
  const Json json = json_of("history " + files, 0);
  EXPECT_EQ(json["verdict"], "stable");
  EXPECT_EQ(json["key"], "order");
  EXPECT_EQ(json["false_alarm"], 0.01);
}

TEST_F(HistoryCli, ATrendByANumberInTheFilesAndByATable) {
  std::string files, table = "name,degrees\n";
  for (int i = 0; i < 6; ++i) {
    const std::string name = "t" + std::to_string(i), degrees = std::to_string(10 * i);
    files += moved(name + ".yaml", 20.0 * i, "temperature_c: " + degrees + "\n");
    table += name + "," + degrees + "\n";
  }
  const Json in_files = json_of("history " + files + "--key temperature_c", 1);
  EXPECT_EQ(in_files["verdict"], "trend");
  spill(path("degrees.csv"), table);
  const Json in_table =
      json_of("history " + files + "--key degrees --values " + path("degrees.csv"), 1);
  EXPECT_EQ(in_table["trend"], in_files["trend"]);
  for (const Json& parameter : in_files["trend"]["parameters"])
    if (parameter["name"] == "cx") {
      EXPECT_NEAR(parameter["px"], 2, 1e-3);
    }
  const Outcome out = run("history " + files + "--key temperature_c --out " + path("h.csv"));
  EXPECT_EQ(out.exit_code, 1);
  EXPECT_EQ(std::ranges::count(slurp(path("h.csv")), '\n'), 7);
  EXPECT_TRUE(slurp(path("h.csv")).starts_with("name,temperature_c,displacement_px,f,sd_f,"));
  const Outcome quiet = run("history " + files + "--quiet --out " + path("h.json"));
  EXPECT_TRUE(quiet.out.empty() && quiet.err.empty()) << quiet.out << quiet.err;
  EXPECT_EQ(Json::parse(slurp(path("h.json")))["verdict"], "trend");
}

TEST_F(HistoryCli, AChangeHasItsDates) {
  std::string files;
  for (int i = 1; i < 7; ++i)
    files += moved("cam_2026-03-0" + std::to_string(i) + ".yaml", i > 3 ? 60 : 0);
  const Json json = json_of("history " + files, 1);
  EXPECT_EQ(json["verdict"], "change");
  EXPECT_EQ(json["key"], "days");
  EXPECT_EQ(json["change"]["from"], 2);
  EXPECT_EQ(json["change"]["to"], 3);
}

TEST_F(HistoryCli, TwoAreTooFewAndBadInputIsOneLine) {
  const std::string a = moved("a.yaml", 0), b = moved("b.yaml", 0);
  EXPECT_EQ(json_of("history " + a + b, 3)["verdict"], "too_few");
  spill(path("bare.yaml"),
        "image_width: 1280\nimage_height: 800\n"
        "camera_matrix: {rows: 3, cols: 3, dt: d, data: [850, 0, 640, 0, 850, 400, 0, 0, 1]}\n"
        "distortion_coefficients: {rows: 1, cols: 5, dt: d, data: [0, 0, 0, 0, 0]}\n"
        "camera_name: bare\nbinning_x: 2\n");  // has a note, which is not printed
  spill(path("wide.yaml"), replaced(camera(), "image_width: 1280", "image_width: 1281"));
  good_run("calibrate " + kDeskSet + " --model fisheye4 --out " + path("fish.yaml"));
  spill(path("few.csv"), "name,value\na,1\n");
  const auto refused = [&](const std::string& rest, const std::string& named) {
    const Outcome outcome = run("history " + rest);
    EXPECT_EQ(outcome.exit_code, 2) << rest;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    EXPECT_HAS(outcome.err, named);
  };
  refused(a, "a.yaml: must be two");
  refused(a + b + path("bare.yaml"), "bare.yaml: has no covariance");
  refused(a + path("wide.yaml"), "wide.yaml: image size must be 1280x800");
  refused(a + path("fish.yaml"), "fish.yaml: must have a lens of the kind");
  refused(a + b + "--key temperature_c", "a.yaml: temperature_c");
  refused(a + b + "--values " + path("few.csv"), "few.csv: has no line of");
  refused(a + b + "--out " + path("h.txt"), "must end in .csv or .json");
}

}  // namespace
}  // namespace tagcal::tools
