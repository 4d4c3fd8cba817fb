#include "commands/calibrate_many.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <exception>
#include <map>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "commands/many_outcomes.hpp"
#include "job/command.hpp"
#include "job/digest.hpp"
#include "job/input.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "job/progress.hpp"
#include "job/shown_parameters.hpp"
#include "report/calibration_report.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

using Outcome = ManyOutcome;
using Row = ManyOutcome::Row;
constexpr std::size_t kNumColumns = ManyOutcome::kNumColumns;

struct DataSet {
  std::string folder;
  std::string name;  // the last part of the folder's path
  fs::path file;     // "": none to write
};

std::vector<DataSet> data_sets(const std::vector<std::string>& folders, const fs::path& out) {
  std::map<std::string, std::string> folder_of;
  std::vector<DataSet> sets;
  for (const std::string& folder : folders) {
    const std::string name = camera_name(folder);
    const auto [other, is_new] = folder_of.emplace(name, folder);
    if (!is_new) {
      throw Error(fmt::format("{}: the folders' names must differ, but {} is called {} too", folder,
                              other->second, name));
    }
    sets.push_back({folder, name, out.empty() ? fs::path() : out / (name + ".yaml")});
  }
  return sets;
}

// The sets of a chunk. Not one run after the other, because sets of neighbouring names may be as
// large as each other.
std::vector<DataSet> chunk_of(std::vector<DataSet> sets, const Chunk& chunk) {
  if (chunk.count == 1) return sets;
  std::ranges::sort(sets, {}, &DataSet::name);
  std::vector<DataSet> some;
  for (std::size_t i = chunk.index - 1; i < sets.size(); i += chunk.count)
    some.push_back(std::move(sets[i]));
  print_note("chunk {}/{}: {} of {} data sets\n", chunk.index, chunk.count, some.size(),
             sets.size());
  return some;
}

std::string fixed(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "-";
}

Row row_of(const std::string& name, const CalibrationAnswer& answer) {
  const Calibration& c = answer.calibration;
  const bool known = c.camera.has_value();
  const Shown focal = known ? shown_parameters(c).front() : Shown();
  return {name,
          std::string(status_name(c.status)),
          c.model.empty() ? "-" : c.model,
          fixed(focal.value, 3),
          fixed(focal.sigma, 3),
          known ? fixed(c.rms_px, 4) : "-",
          std::to_string(c.views.size()),
          std::to_string(c.outliers.size()),
          std::to_string(std::ranges::count(c.findings, Severity::warning, &Finding::severity)),
          fixed(answer.seconds.total, 2)};
}

Outcome calibrate_set(CalibrationJob job, const DataSet& set, bool as_json) {
  job.input.inputs = {set.folder};
  job.input.out = set.file.string();
  const CalibrationAnswer answer = run_job(job);
  Outcome outcome;
  outcome.code = is_answer(answer.calibration.status) ? kAnswer : kNoAnswer;
  if (outcome.code == kAnswer && !set.file.empty()) {
    outcome.yaml = calibration_yaml(answer.calibration);
  }
  outcome.row = row_of(set.name, answer);
  outcome.unit = fleet_row(set.name, answer.calibration);
  if (job.advise) outcome.advice = advice_sentence(answer.advice);
  if (as_json) outcome.json = calibration_json(answer, set.name);
  return outcome;
}

Outcome failure(const DataSet& set, std::string error) {
  std::replace(error.begin(), error.end(), '\n', ' ');
  Outcome outcome;
  outcome.row[0] = set.name;
  outcome.json = failure_json(set.name, error);
  outcome.unit.status = "error";
  outcome.unit.reason = error;
  outcome.error = std::move(error);
  return outcome;
}

// An error in one data set does not stop the others.
Outcome outcome_of(const CalibrationJob& job, const DataSet& set, bool as_json) {
  try {
    return calibrate_set(job, set, as_json);
  } catch (const std::bad_alloc&) {
    return failure(set, "out of memory");
  } catch (const std::exception& error) {
    return failure(set, error.what());
  }
}

// Stands for the contents of all files that a data set has, wherever they are.
std::string digest_of_inputs(InputArguments arguments, const DataSet& set) {
  arguments.inputs = {set.folder};
  const Input input = read_input(arguments);
  std::string text;
  for (const fs::path& file : input.texts)
    text += file.filename().string() + "\n" + digest_of_file(file) + "\n";
  for (const auto& [name, file] : input.files) text += name + "\n" + digest_of_file(file) + "\n";
  return digest_of(text);
}

// "" for bad input, which the calibration will name.
std::string digest_if_readable(const InputArguments& arguments, const DataSet& set) {
  try {
    return digest_of_inputs(arguments, set);
  } catch (const std::exception&) {
    return "";
  }
}

// The calibration first: a summary without it would be wrong. An error replaces no earlier answer.
void write_outcome(Outcome& outcome, const DataSet& set, const std::string& inputs,
                   const KeptOutcomes& kept) {
  if (!outcome.yaml.empty()) write_whole(set.file, outcome.yaml);
  outcome.yaml.clear();
  if (outcome.code != kBadInput || !fs::exists(set.file)) kept.keep(set.name, inputs, outcome);
}

// The outcome of an earlier run, or that of this one, which is then kept. Bad input is tried again.
Outcome kept_outcome_of(const CalibrationJob& job, const DataSet& set, const ManyOutput& output,
                        const KeptOutcomes& kept) {
  const SetLock lock = kept.lock(set.name);
  const std::string inputs = digest_if_readable(job.input, set);
  try {
    if (output.resume && !inputs.empty()) {
      std::optional<Outcome> earlier = kept.find(set.name, inputs);
      if (earlier && (earlier->code != kAnswer || fs::exists(set.file))) return *earlier;
    }
    Outcome outcome = outcome_of(job, set, output.json);
    write_outcome(outcome, set, inputs, kept);
    return outcome;
  } catch (const std::exception& error) {
    return failure(set, error.what());
  }
}

// Throws Error, before any work, for outcomes that cannot be continued.
void check_same_work(const std::vector<DataSet>& sets, const KeptOutcomes& kept) {
  for (const DataSet& set : sets) (void)kept.find(set.name, "");
}

std::string table(const std::vector<Outcome>& outcomes) {
  constexpr std::size_t kNumTexts = 3;  // left-aligned columns
  const Row head = {"data set", "status", "model",    "fx",       "sd",
                    "rms_px",   "views",  "rejected", "warnings", "seconds"};
  std::array<std::size_t, kNumColumns> width{};
  for (std::size_t k = 0; k < kNumColumns; ++k) {
    width[k] = head[k].size();
    for (const Outcome& o : outcomes) width[k] = std::max(width[k], o.row[k].size());
  }
  const auto line = [&](const Row& row) {
    std::string text = fmt::format("{:<{}}", row[0], width[0]);
    for (std::size_t k = 1; k < kNumColumns; ++k)
      text += k < kNumTexts ? fmt::format("  {:<{}}", row[k], width[k])
                            : fmt::format("  {:>{}}", row[k], width[k]);
    return text + "\n";
  };
  std::string text = line(head);
  for (const Outcome& o : outcomes)
    text += o.error.empty() ? line(o.row)
                            : fmt::format("{:<{}}  error: {}\n", o.row[0], width[0], o.error);
  for (const Outcome& o : outcomes)
    if (!o.advice.empty()) text += fmt::format("{}: next view: {}\n", o.row[0], o.advice);
  return text;
}

std::string array(const std::vector<Outcome>& outcomes) {
  std::string text;
  for (const Outcome& o : outcomes) text += (text.empty() ? "[\n" : ",\n") + o.json;
  return text + "]\n";
}

// Returns the worst exit code, and prints how many data sets have it.
ExitCode worst(const std::vector<Outcome>& outcomes) {
  const auto count = [&](ExitCode code) {
    return std::ranges::count_if(outcomes, [&](const Outcome& o) { return o.code == code; });
  };
  const auto bad = count(kBadInput), open = count(kNoAnswer);
  if (bad > 0) print_to_stderr("tagcal: {} of {} data sets: error\n", bad, outcomes.size());
  if (open > 0) {
    print_to_stderr("tagcal: {} of {} data sets: no answer, no file\n", open, outcomes.size());
  }
  if (bad > 0) return kBadInput;
  return open > 0 ? kNoAnswer : kAnswer;
}

}  // namespace

fs::path folder_path(const std::string& folder) {
  const fs::path path = fs::absolute(folder).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

std::string camera_name(const std::string& folder) {
  return folder_path(folder).filename().string();
}

Chunk chunk_of_text(const std::string& text) {
  Chunk chunk;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, chunk.index);
  const char* const second = first.ptr == end ? end : first.ptr + 1;
  const auto last = std::from_chars(second, end, chunk.count);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != '/' || last.ec != std::errc() ||
      last.ptr != end || chunk.index < 1 || chunk.index > chunk.count)
    throw Error(fmt::format("--chunk: must be K/N, with K from 1 to N, got {}", text));
  return chunk;
}

int calibrate_many(const CalibrationJob& job, const ManyOutput& output) {
  if (!job.input.observations.empty()) {
    throw Error("--observations: needs one data set (dataset.yaml names the file of each one)");
  }
  const std::vector<DataSet> sets =
      chunk_of(data_sets(job.input.inputs, output.folder), output.chunk);
  const AnswerFolder folder(output.folder, output.resume);
  for (const DataSet& set : sets) check_text_writable(set.file);
  std::optional<KeptOutcomes> kept;
  if (!output.folder.empty()) kept.emplace(output.folder, output.options);
  if (output.resume) check_same_work(sets, *kept);
  CalibrationJob one = job;
  one.threads = 1;
  one.shows_progress = false;
  std::vector<Outcome> outcomes(sets.size());
  {
    Progress progress("calibrating", static_cast<int>(sets.size()));
    parallel_for(
        sets.size(), job.threads,
        [&](std::size_t i) {
          outcomes[i] = kept ? kept_outcome_of(one, sets[i], output, *kept)
                             : outcome_of(one, sets[i], output.json);
        },
        [&](int done, int) { progress.update(done); });
  }
  const auto answers =
      std::ranges::count_if(outcomes, [](const Outcome& o) { return o.code == kAnswer; });
  if (!output.folder.empty() && answers > 0)
    say_wrote(output.folder, fmt::format("{} calibrations", answers));
  print_answer(output.json ? array(outcomes) : table(outcomes), output.json, output.folder);
  return worst(outcomes);
}

}  // namespace tagcal::tools
