#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <variant>
#include <vector>

// A study is a declaration: tasks, each of which measures the columns of one numbered trial, and
// tables, which are queries on the rows. One loop runs all studies (run_study): it has the threads,
// resumes from its CSV file and writes it.

namespace tagcal::study {

using Value = std::variant<double, std::string>;  // NaN and "" are empty fields of the CSV
using Values = std::vector<Value>;                // in the order of Study::columns

struct Row {
  std::string task;
  std::uint64_t trial = 0;
  Values values;
};

struct Task {
  std::string name;
  // The rows of a trial; none if this trial does not belong to the study. Called from several
  // threads.
  std::function<std::vector<Values>(std::uint64_t trial)> measure;
  int trials = 0;                 // 0: StudyOptions::count
  bool replaces_skipped = false;  // runs further trials until `trials` of them have rows
};

struct StudyOptions {
  std::uint64_t first = 1;          // number of the first trial
  int count = 0, threads = 1;       // trials of a task
  std::vector<std::string> inputs;  // files or folders
  std::map<std::string, std::string> named;
  std::filesystem::path csv;  // empty: none is written

  const std::string& text(const std::string& name) const { return named.at(name); }
  double number(const std::string& name) const;  // throws Error if it is not a number
};

// The rows of a study that a line of a table summarises.
class Sample {
 public:
  Sample(std::span<const std::string> columns, std::vector<const Row*> rows)
      : columns_(columns), rows_(std::move(rows)) {}

  int size() const { return static_cast<int>(rows_.size()); }
  Sample where(const std::string& column, const std::string& text) const;  // the rows with a text
  std::vector<double> numbers(const std::string& column) const;  // those that are not empty
  std::vector<std::string> texts(const std::string& column) const;

 private:
  std::span<const std::string> columns_;
  std::vector<const Row*> rows_;
};

struct Figure {
  std::string heading;
  std::function<std::string(const Sample&)> text;
};

// A line for each value of the keys ("task" or columns), in the order in which they appear.
struct Table {
  std::vector<std::string> keys;
  std::vector<Figure> figures;
};

struct StudyOption {
  std::string name, value, help;  // `value`: the default
};

struct Study {
  std::string name, summary;
  std::string inputs = {};  // what they are; empty: takes none
  bool needs_inputs = true;
  int count = 500;
  std::uint64_t first = 1;
  std::vector<StudyOption> options = {};
  std::vector<std::string> columns = {};
  std::function<std::vector<Task>(const StudyOptions&)> tasks = {};
  std::vector<Table> tables = {};
};

// Runs the trials that are missing in the CSV file, which is written every few seconds and in the
// end. Rows by task and trial, for any number of threads. Throws Error for a file of other options.
std::vector<Row> run_study(const Study& study, const StudyOptions& options,
                           const std::function<void(int, int)>& progress = {});

// The rows of a file that run_study wrote with any options. Throws Error for other columns.
std::vector<Row> read_rows(const Study& study, const std::filesystem::path& file);
std::string rows_text(const Study& study, const StudyOptions& options, std::span<const Row> rows);

// The tables in Markdown.
std::string tables_text(const Study& study, std::span<const Row> rows);

// Figures of a column.
Figure rows_in(const std::string& heading);
Figure sum_of(const std::string& heading, const std::string& column, int digits = 0);
Figure mean_of(const std::string& heading, const std::string& column, int digits);
Figure rms_of(const std::string& heading, const std::string& column, int digits);
Figure largest_of(const std::string& heading, const std::string& column, int digits);
Figure quantile_of(const std::string& heading, const std::string& column, double share, int digits);
// sqrt(sum(a) / sum(b)), or without the root.
Figure root_ratio_of(const std::string& heading, const std::string& a, const std::string& b,
                     int digits);
Figure ratio_of(const std::string& heading, const std::string& a, const std::string& b, int digits);
// "ok 12, weak 3".
Figure counts_of(const std::string& heading, const std::string& column);

}  // namespace tagcal::study
