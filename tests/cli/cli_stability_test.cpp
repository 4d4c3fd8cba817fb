// tagcal stability, from outside.

#include "cli_fixture.hpp"

namespace tagcal::tools {
namespace {

using CliStability = Cli;

TEST_F(CliStability, WritesTableAndPage) {
  const Outcome outcome =
      good_run("stability near-camera line --trials 2 --threads 2 --out " + path("atlas"));
  EXPECT_HAS(outcome.out, "2 maps");
  const std::string csv = slurp(root() / "atlas/line.csv");
  EXPECT_HAS(csv, "line,0.01,50,tagcal estimate_pose,2,");
  const std::string page = slurp(root() / "atlas/atlas.md");
  EXPECT_LT(page.find("Points nearly on a line"), page.find("Points next to the camera"));
  EXPECT_HAS(page, "tagcal stability near-camera line --trials 2 --seed 1");
  EXPECT_TRUE(slurp(root() / "atlas/line.png").starts_with("\x89PNG"));
  EXPECT_HAS(page, "line.png");
}

// All but the times.
TEST_F(CliStability, EqualSeedsEqualOutcomes) {
  std::vector<std::string> tables;
  for (const std::string how : {"--threads 1 --seed 4", "--threads 3 --seed 4", "--seed 5"}) {
    ASSERT_EQ(run("stability line --trials 3 " + how + " --out " + path("a")).exit_code, 0);
    std::istringstream lines(slurp(root() / "a/line.csv"));
    std::string table;
    for (std::string line; std::getline(lines, line);) {
      std::size_t field = 0;
      for (const char c : line) {
        field += c == ',';
        if (field != 12) table += c;
      }
      table += '\n';
    }
    tables.push_back(table);
  }
  EXPECT_EQ(tables[0], tables[1]);
  EXPECT_NE(tables[0], tables[2]);
}

TEST_F(CliStability, ListsItsMaps) {
  const Outcome outcome = good_run("stability --list");
  EXPECT_HAS(outcome.out, "tag-tilt-distance");
  EXPECT_HAS(outcome.out, "focal-distance");
}

TEST_F(CliStability, BadInput) {
  expect_bad_input("stability moon --out " + path("bad"), {"moon", "tag-tilt-distance"});
  expect_bad_input("stability line", {"--out"});
  expect_bad_input("stability line --trials 0 --out " + path("bad"), {"--trials"});
  expect_bad_input("stability line --trials x --out " + path("bad"), {"--trials"});
  expect_bad_input("stability line --threads -1 --out " + path("bad"), {"--threads"});
  spill(root() / "file", "x");
  expect_bad_input("stability line --trials 1 --out " + path("file"), {"file"});
  EXPECT_FALSE(fs::exists(root() / "bad"));
}

}  // namespace
}  // namespace tagcal::tools
