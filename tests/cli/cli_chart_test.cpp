// tagcal chart, from outside.

#include "cli_fixture.hpp"

namespace tagcal::tools {
namespace {

// The columns of a chart.csv that do not depend on the machine: all but the time.
std::vector<std::string> without_times(const std::string& csv) {
  std::vector<std::string> rows;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    // method and panel may hold commas between quotes: the time is the fifth field from the end.
    std::size_t end = line.size();
    for (int i = 0; i < 4; ++i) end = line.rfind(',', end - 1);
    const std::size_t begin = line.rfind(',', end - 1);
    rows.push_back(line.substr(0, begin) + line.substr(end));
  }
  return rows;
}

TEST_F(Cli, chartWritesTablesAndPictures) {
  good_run("chart focal --trials 2 --out " + path("focal"));
  const auto files = bytes_of(path("focal"));
  EXPECT_TRUE(
      files.at("chart.csv")
          .starts_with("job,method,panel,time_us,rms,rms_over_bound,failures,trials\nfocal,"));
  EXPECT_HAS(files.at("chart.md"), "tagcal chart focal --trials 2 --seed 1");
  EXPECT_HAS(files.at("chart.md"), ". 2 trials a panel, seed 1;");
  EXPECT_TRUE(files.contains("trials.csv"));
  EXPECT_TRUE(files.at("chart.png").starts_with("\x89PNG"));
  EXPECT_HAS(files.at("chart.svg"), "<svg");
  EXPECT_EQ(files.size(), 9u);  // three pages
}

TEST_F(Cli, chartIsTheSameForAnyThreads) {
  ASSERT_EQ(run("chart focal --trials 3 --out " + path("one")).exit_code, 0);
  ASSERT_EQ(run("chart focal --trials 3 --threads 2 --out " + path("two")).exit_code, 0);
  EXPECT_EQ(without_times(slurp(root() / "one" / "chart.csv")),
            without_times(slurp(root() / "two" / "chart.csv")));
}

TEST_F(Cli, chartRefusesBadInput) {
  const auto before = names();
  expect_bad_input("chart --out " + path("x"), {"JOB"});
  expect_bad_input("chart poses --out " + path("x"), {"unknown job poses"});
  expect_bad_input("chart pose", {"--out"});
  expect_bad_input("chart pose --trials 0 --out " + path("x"), {"--trials", "1 or more"});
  expect_bad_input("chart pose --seed -1 --out " + path("x"), {"--seed"});
  expect_bad_input("chart pose --trials 1 --out " + path("scene.yaml"), {"must be a folder"});
  EXPECT_EQ(names(), before);
}

}  // namespace
}  // namespace tagcal::tools
