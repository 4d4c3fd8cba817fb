// tagcal detect --explain and --draw, from outside.
#include "cli_fixture.hpp"
#include "job/warning_groups.hpp"
#include "report/findings.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
namespace {

using Lines = std::vector<std::string>;

TEST_F(Cli, DrawWritesAPictureOfEachView) {
  const Outcome outcome = good_run("detect " + path("set") + " --draw " + path("drawn"));
  EXPECT_EQ(outcome.out, run("detect " + path("set")).out);
  const auto drawn = bytes_of(root() / "drawn");
  EXPECT_EQ(drawn.size(), 6u);
  const Image8 before = read_image(root() / "set/images/000.png");
  const Image8 after = read_image(root() / "drawn/000.png");
  ASSERT_EQ(after.size(), before.size());
  int changed = 0;
  for (std::size_t i = 0; i < before.pixels().size(); ++i)
    changed += std::abs(before.pixels()[i] - after.pixels()[i]) > 20;
  EXPECT_GT(changed, 1000);
  EXPECT_LT(changed, 640 * 400 / 4);
  expect_bad_input("detect " + path("set") + " --draw " + path("scene.yaml"), {"scene.yaml"});
}

TEST_F(Cli, TwoPicturesOfOneNameAreNotDrawnOverEachOther) {
  fs::create_directories(root() / "a");
  fs::create_directories(root() / "b");
  fs::copy_file(root() / "set/images/000.png", root() / "a/x.png");
  fs::copy_file(root() / "set/images/001.png", root() / "b/x.png");
  expect_bad_input("detect --target " + path("set/target.yaml") + " " + path("a/x.png") + " " +
                       path("b/x.png") + " --draw " + path("over"),
                   {"x.png", "two pictures"});
  EXPECT_FALSE(fs::exists(root() / "over"));
}

TEST_F(Cli, ExplainNamesTheMistakeOnStderr) {
  const std::string target = slurp(root() / "set/target.yaml");
  spill(root() / "kalibr.yaml", replaced(target, "border_bits: 1", "border_bits: 2"));
  const std::string picture = path("set/images/000.png");
  const Outcome good =
      good_run("detect --target " + path("set/target.yaml") + " " + picture + " --explain");
  EXPECT_EQ(good.out, run("detect --target " + path("set/target.yaml") + " " + picture).out);
  EXPECT_HAS(good.err, "four-sided shapes");
  EXPECT_LACKS(good.err, "wrong");
  const Outcome bad =
      good_run("detect --target " + path("kalibr.yaml") + " " + picture + " --explain");
  EXPECT_HAS(bad.err, "wrong border: ");
  // It does not advise the option that was given, or to search for what it has named.
  write_png(root() / "grey.png", Image8({640, 400}, 128));
  const std::string grey = "detect --target " + path("set/target.yaml") + " " + path("grey.png");
  const auto advises = [](const Outcome& o) {
    return (o.out + o.err).find("what to do --explain") != std::string::npos;
  };
  EXPECT_TRUE(advises(run(grey)));
  EXPECT_FALSE(advises(run(grey + " --explain")));
  EXPECT_FALSE(advises(bad));
}

// What it says to type finds the tags.
TEST_F(Cli, ASearchForAFamilyNamesTheKindThatIsThere) {
  const std::string picture = path("set/images/000.png");
  const Outcome none =
      run("detect " + picture + " --family tag36h11 --border-bits 2 --out " + path("kind.csv"));
  const std::string advice = "tags of another kind: ";
  const std::size_t at = none.out.find(advice);
  ASSERT_NE(at, std::string::npos) << none.out << none.err;
  const std::size_t begin = at + advice.size();
  const std::string options = none.out.substr(begin, none.out.find('\n', begin) - begin);
  EXPECT_EQ(options, "--family tag36h11 --border-bits 1");
  const Outcome found = run("detect " + picture + " " + options + " --out " + path("kind.csv"));
  EXPECT_TRUE(found.out.starts_with("OK: ")) << found.out;
}

TEST_F(Cli, DetectSaysFirstWhatWasFound) {
  const Image8 grey(read_image(root() / "set/images/000.png").size(), 128);
  fs::create_directories(root() / "mixed");
  for (const char* name : {"x0.png", "x1.png", "x2.png", "x3.png"})
    write_png(root() / "mixed" / name, grey);
  const std::string target = "detect --target " + path("set/target.yaml") + " --no-cache ";

  const Outcome none = good_run(target + path("mixed") + " --out " + path("none.csv"));
  EXPECT_TRUE(none.out.starts_with("NOTHING FOUND: the target is in none of 4 pictures\n"));
  EXPECT_HAS(none.err, "x0.png: no tag of the boards found; and 3 more like it: x1.png, x2.png");

  fs::copy_file(root() / "set/images/000.png", root() / "mixed/a.png");
  const Outcome partly = run(target + path("mixed") + " --verbose --out " + path("part.csv"));
  EXPECT_TRUE(partly.out.starts_with("PARTLY: 1 of 5 pictures shows the target: ")) << partly.out;
  EXPECT_HAS(partly.out, "nothing    x0.png, x1.png, x2.png and 1 more\n");
  EXPECT_HAS(partly.out, "\n  a.png   12 of 12 tags, 48 corners\n");
  EXPECT_EQ(partly.out.find('\033'), std::string::npos);
}

TEST_F(Cli, DamagedPicturesAreLeftOutOfASearchForAFamily) {
  const std::string good = slurp(root() / "set/images/000.png");
  spill(root() / "damaged/a.png", good);
  spill(root() / "damaged/b.png", good.substr(0, good.size() / 2));
  spill(root() / "damaged/c.png", slurp(root() / "set/images/001.png"));
  const std::string search = "detect --family tag36h11 ";
  const std::string all =
      search + path("damaged/a.png") + " " + path("damaged/b.png") + " " + path("damaged/c.png");
  const Outcome outcome = good_run(all + " --draw " + path("damaged-drawn"));
  EXPECT_EQ(outcome.out, run(search + path("damaged/a.png") + " " + path("damaged/c.png")).out);
  EXPECT_HAS(outcome.err, "b.png");
  EXPECT_HAS(outcome.err, "the picture is left out");
  EXPECT_EQ(bytes_of(root() / "damaged-drawn").size(), 2u);
  expect_bad_input(all + " --strict", {"b.png"});
  expect_bad_input(search + path("damaged/b.png"), {"b.png"});
}

TEST(WarningGroups, OneLineForManyAlike) {
  EXPECT_EQ(in_groups(Lines()), Lines());
  const Lines two = {"a.png: 3 tags on no board: 1 2 3", "b.png: 1 tags on no board: 7"};
  EXPECT_EQ(in_groups(two), two);
  EXPECT_EQ(in_groups(Lines{"a.png: 3 tags on no board: 1 2 3", "general",
                            "b.png: 1 tags on no board: 7", "c.png: other",
                            "c.png: 1 tags on no board: 8, 9", "d.png: 2 tags on no board: 1 2"}),
            (Lines{"a.png: 3 tags on no board: 1 2 3; and 3 more like it: b.png, c.png, ..",
                   "general", "c.png: other"}));
}

TEST(WarningGroups, OfFindingsKeepCodeAndSeverity) {
  std::vector<Finding> findings;
  for (const char* name : {"a", "b", "c", "d"}) {
    findings.push_back({"view_unused", Severity::warning, std::string(name) + ".png: not used"});
    findings.push_back({"input", Severity::note, std::string(name) + ".png: is left out"});
  }
  const std::vector<Finding> groups = in_groups(findings);
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[0].sentence, "a.png: not used; and 3 more like it: b.png, c.png, ..");
  EXPECT_EQ(groups[0].code, "view_unused");
  EXPECT_EQ(groups[1].severity, Severity::note);
}

TEST(WarningGroups, TheVerdictCountsTheLines) {
  std::vector<Finding> findings = {{"input", Severity::note, "a.png: is left out"}};
  EXPECT_EQ(ok_text(findings), "OK: ");
  for (const char* name : {"a", "b", "c", "d"})
    findings.push_back({"view_unused", Severity::warning, std::string(name) + ".png: not used"});
  EXPECT_EQ(ok_text(findings), "OK, 1 warning: ");
  findings.push_back({"coverage", Severity::warning, "no corners in the lower left corner"});
  EXPECT_EQ(ok_text(findings), "OK, 2 warnings: ");
}

}  // namespace
}  // namespace tagcal::tools
