// The loop of studies: rows, resuming and tables.

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "expect.hpp"
#include "study/harness/csv.hpp"
#include "study/harness/study.hpp"
#include "study/quantile.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal {
using namespace study;
namespace {

namespace fs = std::filesystem;

std::atomic<int> calls = 0;

// Odd trials have a row; `b` runs until two of them have one.
Study counted_study() {
  const auto measure = [](std::uint64_t trial) -> std::vector<Values> {
    ++calls;
    if (trial % 2 == 0) return {};
    return {{static_cast<double>(trial), trial == 3 ? std::nan("") : 2., std::string("a, b")}};
  };
  return {.name = "small",
          .summary = "",
          .options = {{"model", "auto", ""}},
          .columns = {"x", "y", "text"},
          .tasks =
              [=](const StudyOptions&) {
                return std::vector<Task>{{"a", measure}, {"b", measure, 2, true}};
              },
          .tables = {{{"task"},
                      {rows_in("rows"), sum_of("x", "x"), mean_of("y", "y", 1),
                       ratio_of("x / y", "x", "y", 2), counts_of("texts", "text")}}}};
}

StudyOptions options_of(int count, const fs::path& csv = {}) {
  return {.first = 1,
          .count = count,
          .threads = 2,
          .inputs = {},
          .named = {{"model", "auto"}},
          .csv = csv};
}

TEST(Harness, TablesAreQueriesOnTheRows) {
  const Study study = counted_study();
  const std::vector<Row> rows = run_study(study, options_of(5));
  ASSERT_EQ(rows.size(), 5u);  // 1, 3, 5 of a; 1, 3 of b
  EXPECT_EQ(rows[3].task, "b");
  EXPECT_EQ(rows[4].trial, 3u);
  EXPECT_EQ(tables_text(study, rows),
            "| task | rows | x | y | x / y | texts |\n|---|--:|--:|--:|--:|--:|\n"
            "| a | 3 | 9 | 2.0 | 2.25 | a, b 3 |\n| b | 2 | 4 | 2.0 | 2.00 | a, b 2 |\n");
}

TEST(Harness, ResumesFromItsFileAndGivesTheSameBytes) {
  const fs::path file = fs::path(testing::TempDir()) / "harness_test.csv";
  const fs::path whole = fs::path(testing::TempDir()) / "harness_test_whole.csv";
  fs::remove(file), fs::remove(whole);
  const Study study = counted_study();
  run_study(study, options_of(3, file));
  calls = 0;
  run_study(study, options_of(7, file));
  // 2, 4 to 7 of a, 2 of b: trials without rows leave no trace.
  EXPECT_EQ(calls, 6);
  run_study(study, options_of(7, whole));
  EXPECT_EQ(read_text(file.string()), read_text(whole.string()));
  EXPECT_HAS(read_text(file.string()), "\na,3,3,,\"a, b\"\n");
  StudyOptions others = options_of(7, file);
  others.named["model"] = "f";
  EXPECT_THROW(run_study(study, others), Error);
}

TEST(Harness, NothingIsWithinACovarianceThatIsNotPositive) {
  const Eigen::Vector2d error(3, 4);
  EXPECT_DOUBLE_EQ(squared_distance(error, Eigen::Vector2d(9, 4).asDiagonal()), 5);
  EXPECT_EQ(squared_distance(error, Eigen::Vector2d(-9, -4).asDiagonal()), HUGE_VAL);
  EXPECT_EQ(squared_distance(error, Eigen::Matrix2d::Constant(std::nan(""))), HUGE_VAL);
}

TEST(Harness, FieldsOfCsv) {
  const std::vector<std::string> fields = {"a", "b, c", "say \"so\"", ""};
  const std::string line = csv_line(fields);
  EXPECT_EQ(line, "a,\"b, c\",\"say \"\"so\"\"\",\n");
  EXPECT_EQ(csv_cells(line.substr(0, line.size() - 1)), fields);
  EXPECT_THROW(options_of(1).number("model"), Error);
}

}  // namespace
}  // namespace tagcal
