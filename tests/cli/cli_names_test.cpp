// Names of files that are not plain text: control characters, line ends, bytes that are not UTF-8.
#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

const std::string kLines = "a\nint evil;\x1b[2K&<\x7f>.png";
const std::string kLatin = "caf\xe9.png";
const std::string kLatinShown = "caf\xef\xbf\xbd.png";

class CliNames : public Cli {
 protected:
  // What `tagcal view` prints of a camera whose file has this name, which it shows.
  static std::string view(const std::string& name, const std::string& option) {
    fs::create_directories(root() / "cameras");
    fs::copy(root() / "set/truth.yaml", root() / "cameras" / name,
             fs::copy_options::overwrite_existing);
    const Outcome outcome = good_run("view " + quoted(root() / "cameras" / name) + " " + option);
    return outcome.out;
  }

  // The pictures of the data set, the first one under another name.
  static std::string pictures(const std::string& folder, const std::string& first) {
    fs::copy(root() / "set/images", root() / folder);
    fs::rename(root() / folder / "000.png", root() / folder / first);
    return "--target " + path("set/target.yaml") + " " + path(folder);
  }

  static std::string quoted(const fs::path& file) { return "'" + file.string() + "'"; }
};

TEST_F(CliNames, AreOneCommentOfCode) {
  const std::string code = view(kLines, "--opengl");
  EXPECT_TRUE(code.starts_with("// a?int evil;?[2K&<?>.png: ")) << code.substr(0, 200);
}

TEST_F(CliNames, KeepDrawingsXml) {
  const std::string drawing = view(kLines, "--svg"), latin = view(kLatin, "--svg");
  EXPECT_EQ(drawing, view("a?int evil;?[2K&<?>.png", "--svg"));
  EXPECT_EQ(latin, view(kLatinShown, "--svg"));
  EXPECT_NE(latin, drawing);
  EXPECT_EQ((drawing + latin).find_first_of("\x1b\x7f\xe9"), std::string::npos);
}

TEST_F(CliNames, KeepJsonUtf8) {
  EXPECT_EQ(Json::parse(view(kLatin, "--json"))["image"], kLatinShown);
  const fs::path set = root() / "damaged";
  fs::copy(root() / "set", set, fs::copy_options::recursive);
  spill(set / "images" / kLatin, "no picture");
  const Outcome check =
      good_run("validate " + path("set/truth.yaml") + " --json --dataset " + set.string());
  EXPECT_HAS(Json::parse(check.out)["warnings"].dump(), kLatinShown);
}

TEST_F(CliNames, TheCornerCacheKeepsTheOtherPictures) {
  const std::string detect =
      "detect " + pictures("latin", kLatin) + " --out " + path("corners.csv");
  const Outcome first = good_run(detect), again = run(detect);
  EXPECT_LACKS(first.err, "are not kept");
  EXPECT_HAS(again.err, "corners of 5 of 6 pictures are those of");
}

TEST_F(CliNames, OfSeveralLinesAreRefusedBeforeTheWork) {
  expect_bad_input("detect " + pictures("lines", kLines) + " --out " + path("lines.csv"),
                   {path("lines") + "/a int evil;", "the name of a picture must be one line"});
  EXPECT_FALSE(fs::exists(root() / "lines.csv.corners-cache"));
}

}  // namespace
}  // namespace tagcal::tools
