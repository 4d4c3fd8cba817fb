// What a command writes replaces none of the files that it reads, and nothing that it was not
// asked for.
#include "cli_fixture.hpp"

namespace tagcal::tools {
namespace {

class CliOutputs : public Cli {
 protected:
  static void SetUpTestSuite() {
    Cli::SetUpTestSuite();
    ASSERT_EQ(run("detect " + path("set") + " --out " + corners()).exit_code, 0);
    ASSERT_EQ(run("calibrate " + set_with_corners() + " --out " + camera()).exit_code, 0);
    fs::create_directories(root() / "photos");
    for (const char* const name : {"000.png", "001.png"})
      fs::copy(root() / "set/images" / name, root() / "photos" / name);
    spill(root() / "points.csv", "x_m,y_m,z_m\n0.1,0.2,1\n");
  }
  static std::string corners() { return path("corners.csv"); }
  static std::string camera() { return path("camera.yaml"); }
  static std::string set_with_corners() { return path("set") + " --observations " + corners(); }

  // Refused in one line, and no file of the test has changed.
  static void expect_refused(const std::string& arguments, const std::string& part) {
    const std::map<std::string, std::string> before = bytes_of(root());
    expect_bad_input(arguments, {part});
    std::map<std::string, std::string> after = bytes_of(root());
    std::erase_if(after, [](const auto& file) { return file.first.find("std") == 0; });
    for (const auto& [name, bytes] : after)
      EXPECT_TRUE(before.contains(name) && before.at(name) == bytes) << arguments << ": " << name;
  }
};

TEST_F(CliOutputs, NoInputIsReplaced) {
  const std::string input = "is an input, which would be replaced";
  const std::string from_set = "calibrate " + set_with_corners() + " --out ";
  for (const std::string file :
       {"set/dataset.yaml", "set/target.yaml", "set/truth.yaml", "set/../set/target.yaml"})
    expect_refused(from_set + path(file), file + ": " + input);
  expect_refused(from_set + corners(), "corners.csv: has the name of another kind of file");
  expect_refused(from_set + camera() + " --start " + camera(), input);
  expect_refused("calibrate " + path("set") + " --uncertainty " + path("set/images/000.png"),
                 input);
  const std::string target = " --target " + path("set/target.yaml");
  expect_refused("detect " + path("photos") + target + " --out " + path("set/target.yaml"), input);
  expect_refused("watch " + path("photos") + target + " --out " + path("set/target.yaml"), input);
  expect_refused("project " + path("points.csv") + " --camera " + camera() + " --out " + camera(),
                 input);
  expect_refused("convert " + camera() + " " + camera() + " --to ros", input);
  expect_refused("board " + path("set/target.yaml") + " --out " + path("set/target.yaml"), "");
  expect_refused(
      "pose " + path("photos") + target + " --camera " + camera() + " --draw " + path("photos"),
      "photos has the pictures");
}

// The shell puts the first of several pictures behind an option whose value was forgotten.
TEST_F(CliOutputs, ATextIsNotWrittenAsAPicture) {
  const std::string target = "--target " + path("set/target.yaml") + " ";
  const std::string pictures = path("photos/000.png") + " " + path("photos/001.png");
  expect_refused("detect " + target + "--out " + pictures, "000.png: has the name of a picture");
  expect_refused("detect " + target + "--out= " + pictures, "--out: must not be empty");
  expect_refused("calibrate " + target + "--out " + pictures, "has the name of a picture");
  expect_refused("watch " + path("photos") + " " + target + "--out " + path("photos/new.jpg"),
                 "has the name of a picture");
}

TEST_F(CliOutputs, TwoOptionsDoNotWriteOneFile) {
  const std::string both = "two options would write it";
  expect_refused("calibrate " + set_with_corners() + " --out " + path("a.svg") + " --uncertainty " +
                     path("a.svg"),
                 "a.svg: has the name of another kind of file");
  expect_refused("convert " + camera() + " " + path("a.svg") +
                     " --to opencv --model opencv5 --picture " + path("./a.svg"),
                 both);
}

TEST_F(CliOutputs, AnEmptyTextIsNoValue) {
  for (const std::string option : {"--out", "--start", "--model", "--uncertainty", "--report"}) {
    expect_refused("calibrate " + set_with_corners() + " " + option + " ''",
                   option + ": must not be empty");
    expect_refused("calibrate " + set_with_corners() + " " + option + "= --json",
                   option + ": must not be empty");
  }
  expect_refused("convert " + camera() + " " + path("new.yaml") + " --target ''",
                 "--target: must not be empty");
  expect_refused("detect ''", "must not be empty");
}

// The names in truth.yaml come from elsewhere.
TEST_F(CliOutputs, ForceRemovesFilesOfTheFolderOnly) {
  const std::string out = path("forced"), again = "render " + path("scene.yaml") + " --out " + out;
  ASSERT_EQ(run(again).exit_code, 0);
  const std::vector<fs::path> precious = {root() / "precious", root() / "forced/precious",
                                          root() / "forced/images/notes.txt"};
  for (const fs::path& file : precious) spill(file, "precious");
  std::string truth = slurp(root() / "forced/truth.yaml");
  const std::size_t first = truth.find("  - {image: \"000.png\"");
  ASSERT_NE(first, std::string::npos) << truth;
  const std::string view = truth.substr(first, truth.find('\n', first) + 1 - first);
  for (const std::string& name : {precious[0].string(), std::string("../../precious"),
                                  std::string("../precious"), std::string("..")}) {
    std::string named = view;
    truth += named.replace(named.find("000.png"), 7, name);
  }
  spill(root() / "forced/truth.yaml", truth);
  ASSERT_EQ(run(again + " --force").exit_code, 0);
  for (const fs::path& file : precious) EXPECT_EQ(slurp(file), "precious") << file;
}

// Replaced by a file of that name, all that was printed before and after would be lost.
TEST_F(CliOutputs, TheFileOfStdoutIsWrittenTo) {
  const std::string csv = slurp(corners());
  for (const std::string redirection : {">>", ">"}) {
    const std::string file = path("redirected.txt");
    spill(file, redirection == ">" ? "" : "before\n");
    const std::string line = "(echo before; " + program() + " detect " + path("set") +
                             " --out /dev/stdout; echo after) 2>/dev/null " + redirection + file;
    ASSERT_EQ(std::system(line.c_str()), 0);
    EXPECT_EQ(slurp(file),
              (redirection == ">" ? "before\n" : "before\nbefore\n") + csv + "after\n");
  }
  EXPECT_FALSE(fs::exists("/dev/stdout.corners-cache"));
}

// The link /dev/stdout then names no path.
TEST_F(CliOutputs, APipeIsWrittenTo) {
  const std::string csv = slurp(corners()), file = path("piped.txt");
  for (const std::string out : {"-", "/dev/stdout"}) {
    const std::string line =
        program() + " detect " + path("set") + " --out " + out + " 2>/dev/null | cat > " + file;
    ASSERT_EQ(std::system(line.c_str()), 0);
    EXPECT_EQ(slurp(file), csv) << out;
  }
}

}  // namespace
}  // namespace tagcal::tools
