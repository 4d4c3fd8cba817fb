// tagcal chart, from outside.

#include "cli_fixture.hpp"

namespace tagcal::tools {
namespace {

bool has_gnuplot() { return std::system("gnuplot --version >/dev/null 2>&1") == 0; }

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
  const Outcome outcome = run("chart focal --trials 2 --out " + path("focal"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto files = bytes_of(path("focal"));
  EXPECT_TRUE(
      files.at("chart.csv")
          .starts_with("job,method,panel,time_us,rms,rms_over_bound,failures,trials\nfocal,"));
  EXPECT_NE(files.at("chart.md").find("tagcal chart focal --trials 2 --seed 1"), std::string::npos);
  EXPECT_NE(files.at("chart.md").find(". 2 trials a panel, seed 1;"), std::string::npos);
  EXPECT_TRUE(files.contains("trials.csv"));
  if (!has_gnuplot()) GTEST_SKIP() << "no gnuplot: no pictures";
  EXPECT_TRUE(files.at("chart.png").starts_with("\x89PNG"));
  EXPECT_NE(files.at("chart.svg").find("<svg"), std::string::npos);
  EXPECT_NE(files.at("chart.svg").find("estimate_pose_and_focal"), std::string::npos);
  EXPECT_EQ(files.size(), 9u);  // three pages, and no scripts left
}

TEST_F(Cli, chartIsTheSameForAnyThreads) {
  ASSERT_EQ(run("chart focal --trials 3 --out " + path("one")).exit_code, 0);
  ASSERT_EQ(run("chart focal --trials 3 --threads 2 --out " + path("two")).exit_code, 0);
  EXPECT_EQ(without_times(slurp(root() / "one" / "chart.csv")),
            without_times(slurp(root() / "two" / "chart.csv")));
}

TEST_F(Cli, chartWithoutGnuplotHasTheTables) {
  // The PATH has the command only, no gnuplot.
  const std::string saved = std::getenv("PATH");
  setenv("PATH", path("nowhere").c_str(), 1);
  const std::string out = path("bare");
  const int status = std::system((std::string(TAGCAL_COMMAND) + " chart focal --trials 1 --out " +
                                  out + " >" + path("stdout.txt") + " 2>" + path("stderr.txt"))
                                     .c_str());
  setenv("PATH", saved.c_str(), 1);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  const std::string err = slurp(path("stderr.txt"));
  EXPECT_NE(err.find("gnuplot is missing"), std::string::npos) << err;
  const auto files = bytes_of(out);
  EXPECT_EQ(files.size(), 3u);
  EXPECT_TRUE(files.contains("chart.csv"));
  EXPECT_TRUE(files.contains("chart.md"));
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
