#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>
#include <set>

#include "study/harness/csv.hpp"
#include "study/harness/study.hpp"
#include "study/study_threads.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::study {
using namespace internal;
namespace {

constexpr auto kSaveEvery = std::chrono::seconds(10);

std::string text_of(const Value& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  const double number = std::get<double>(value);
  return std::isnan(number) ? "" : fmt::format("{}", number);
}

Value value_of(const std::string& text) {
  double number = std::numeric_limits<double>::quiet_NaN();
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || (error == std::errc() && end == text.data() + text.size())) return number;
  return text;
}

// The lines above the rows: what was asked for, and the names of the columns.
std::string options_line(const Study& study, const StudyOptions& options) {
  std::string text = "# tagcal-study " + study.name;
  for (const auto& [name, value] : options.named) text += fmt::format(" --{} {}", name, value);
  for (const std::string& input : options.inputs) text += " " + input;
  return text + "\n";
}

std::string columns_line(const Study& study) {
  std::vector<std::string> fields = {"task", "trial"};
  fields.insert(fields.end(), study.columns.begin(), study.columns.end());
  return csv_line(fields);
}

std::string line_of(const Row& row) {
  std::vector<std::string> fields = {row.task, std::to_string(row.trial)};
  for (const Value& value : row.values) fields.push_back(text_of(value));
  return csv_line(fields);
}

Row row_of(const std::string& line, std::size_t num_columns, const std::string& file) {
  const std::vector<std::string> cells = csv_cells(line);
  if (cells.size() != num_columns + 2) throw Error(file + ": has a line of another length");
  Row row{cells[0], 0, {}};
  std::from_chars(cells[1].data(), cells[1].data() + cells[1].size(), row.trial);
  std::transform(cells.begin() + 2, cells.end(), std::back_inserter(row.values), value_of);
  return row;
}

// The rows of a study, and the file that keeps them.
class Rows {
 public:
  Rows(const Study& study, const StudyOptions& options) : study_(study), options_(options) {
    if (options.csv.empty() || !std::filesystem::exists(options.csv)) return;
    if (!read_text(options.csv.string()).starts_with(rows_text(study, options, {})))
      throw Error(options.csv.string() + ": was made with other options, or has other columns; name another file");
    for (Row& row : read_rows(study, options.csv)) add(std::move(row));
  }

  bool has(const std::string& task, std::uint64_t trial) const {
    return done_.contains({task, trial});
  }

  void add(const std::string& task, std::uint64_t trial, std::vector<Values> rows) {
    const std::scoped_lock lock(mutex_);
    for (Values& values : rows) add({task, trial, std::move(values)});
    if (std::chrono::steady_clock::now() - saved_ > kSaveEvery) save();
  }

  void sort(const std::vector<Task>& tasks) {
    const auto place = [&](const Row& row) {
      const auto task = std::ranges::find(tasks, row.task, &Task::name);
      return std::pair(task - tasks.begin(), row.trial);
    };
    std::ranges::stable_sort(rows_, {}, place);
  }

  void save() {
    saved_ = std::chrono::steady_clock::now();
    if (!options_.csv.empty()) write_whole(options_.csv, rows_text(study_, options_, rows_));
  }

  const std::vector<Row>& rows() const { return rows_; }

 private:
  void add(Row row) {
    done_.insert({row.task, row.trial});
    rows_.push_back(std::move(row));
  }

  const Study& study_;
  const StudyOptions& options_;
  std::vector<Row> rows_;
  std::set<std::pair<std::string, std::uint64_t>> done_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point saved_ = std::chrono::steady_clock::now();
};

struct Attempt {
  const Task* task;
  std::uint64_t trial;
};

// The next trials of a task that may be needed; `next` is the first one that was never asked for.
void ask_further(const Task& task, const StudyOptions& options, const Rows& rows,
                 std::uint64_t& next, std::vector<Attempt>& missing) {
  const int wanted = task.trials > 0 ? task.trials : options.count;
  int counted = 0;
  for (std::uint64_t trial = options.first; trial < next; ++trial)
    counted += rows.has(task.name, trial);
  if (next > options.first && !task.replaces_skipped) return;
  for (; counted < wanted; ++counted, ++next)
    if (!rows.has(task.name, next)) missing.push_back({&task, next});
}

}  // namespace

std::vector<Row> read_rows(const Study& study, const std::filesystem::path& file) {
  const std::string text = read_text(file.string()), columns = columns_line(study);
  const std::size_t head = text.find('\n') + 1;  // the options
  if (!text.starts_with("# tagcal-study " + study.name) ||
      text.compare(head, columns.size(), columns) != 0)
    throw Error(file.string() + ": is not a file of tagcal-study " + study.name +
                ", or one with other columns");
  std::vector<Row> rows;
  // A line without an end was cut when the program was stopped.
  for (std::size_t at = head + columns.size(), end; (end = text.find('\n', at)) != text.npos;
       at = end + 1)
    rows.push_back(row_of(text.substr(at, end - at), study.columns.size(), file.string()));
  return rows;
}

std::string rows_text(const Study& study, const StudyOptions& options, std::span<const Row> rows) {
  std::string text = options_line(study, options) + columns_line(study);
  for (const Row& row : rows) text += line_of(row);
  return text;
}

std::vector<Row> run_study(const Study& study, const StudyOptions& options,
                           const std::function<void(int, int)>& progress) {
  const OneOpenCvThread one_thread;
  const std::vector<Task> tasks = study.tasks(options);
  Rows rows(study, options);
  std::vector<std::uint64_t> next(tasks.size(), options.first);
  for (;;) {
    std::vector<Attempt> missing;
    for (std::size_t i = 0; i < tasks.size(); ++i)
      ask_further(tasks[i], options, rows, next[i], missing);
    if (missing.empty()) break;
    // Each trial visits all tasks, so that a slow moment of the machine affects all of them.
    std::ranges::stable_sort(missing, {}, &Attempt::trial);
    parallel_for(
        missing.size(), options.threads,
        [&](std::size_t i) {
          const auto& [task, trial] = missing[i];
          rows.add(task->name, trial, task->measure(trial));
        },
        progress);
  }
  rows.sort(tasks);
  rows.save();
  return rows.rows();
}

double StudyOptions::number(const std::string& name) const {
  const Value value = value_of(text(name));
  if (const auto* number = std::get_if<double>(&value); number && std::isfinite(*number))
    return *number;
  throw Error(fmt::format("--{}: must be a number, got {}", name, text(name)));
}

Sample Sample::where(const std::string& column, const std::string& text) const {
  const std::vector<std::string> all = texts(column);
  std::vector<const Row*> some;
  for (std::size_t i = 0; i < rows_.size(); ++i)
    if (all[i] == text) some.push_back(rows_[i]);
  return {columns_, some};
}

std::vector<double> Sample::numbers(const std::string& column) const {
  const auto at = std::ranges::find(columns_, column) - columns_.begin();
  std::vector<double> numbers;
  for (const Row* row : rows_)
    if (const auto* number = std::get_if<double>(&row->values[static_cast<std::size_t>(at)]);
        number && !std::isnan(*number))
      numbers.push_back(*number);
  return numbers;
}

std::vector<std::string> Sample::texts(const std::string& column) const {
  const auto at = std::ranges::find(columns_, column) - columns_.begin();
  std::vector<std::string> texts;
  for (const Row* row : rows_)
    texts.push_back(column == "task" ? row->task
                                     : text_of(row->values[static_cast<std::size_t>(at)]));
  return texts;
}

}  // namespace tagcal::study
