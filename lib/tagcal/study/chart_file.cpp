#include "tagcal/study/chart_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "tagcal/error.hpp"

namespace tagcal {
namespace {

constexpr std::string_view kFirstLine = "# tagcal chart: trials, version 1";
constexpr std::string_view kHeader = "panel,method,trial,time_us,error,error_over_bound";
constexpr std::string_view kBetween = " | ";

std::vector<std::string_view> split(std::string_view text, std::string_view between) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t at = text.find(between);
    parts.push_back(text.substr(0, at));
    if (at == std::string_view::npos) return parts;
    text.remove_prefix(at + between.size());
  }
}

// A name of a method as a CSV field: with quotes where it has a comma.
std::string field(const std::string& text) {
  return text.find(',') == std::string::npos ? text : fmt::format("\"{}\"", text);
}

class TrialsReader {
 public:
  TrialsReader(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  ChartResult read() {
    if (next_line() != kFirstLine) fail("is no file of trials by tagcal chart");
    std::string_view line = next_line();
    for (; line.starts_with("# "); line = next_line()) read_key(line.substr(2));
    if (line != kHeader) fail(fmt::format("expected {}", kHeader));
    while (!text_.empty()) read_trial(next_line());
    if (result_.job.empty() || result_.shards.empty()) fail("has no job or no shard");
    check_whole();
    return std::move(result_);
  }

 private:
  [[noreturn]] void fail(const std::string& why) const {
    throw Error(fmt::format("{}:{}: {}", name_, line_, why));
  }

  // Every method of a panel has had every trial of the shards, and no panel is without.
  void check_whole() const {
    int expected = 0;
    for (const Shard& s : result_.shards) {
      if (s.count < 1 || s.index < 1 || s.index > s.count) fail("has a shard that is none");
      for (int t = s.index - 1; t < result_.num_trials; t += s.count) ++expected;
    }
    std::map<std::pair<int, int>, int> count;
    std::set<int> panels;
    for (const ChartTrial& t : result_.trials) ++count[{t.panel, t.method}], panels.insert(t.panel);
    for (const auto& [key, n] : count)
      if (n != expected)
        fail(fmt::format("panel {}, method {}: must have {} trials, has {}", key.first, key.second,
                         expected, n));
    if (expected > 0 && panels.size() != result_.panels.size()) fail("has panels without a trial");
  }

  std::string_view next_line() {
    ++line_;
    const std::size_t end = text_.find('\n');
    const std::string_view line = text_.substr(0, end);
    text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + 1);
    return line;
  }

  template <typename T>
  T number(std::string_view text) const {
    T value{};
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || stop != text.data() + text.size() ||
        !std::isfinite(static_cast<double>(value)))
      fail(fmt::format("expected a number, got \"{}\"", text));
    return value;
  }

  std::vector<std::string_view> parts(std::string_view text, std::size_t count,
                                      std::string_view between) const {
    std::vector<std::string_view> all = split(text, between);
    if (all.size() != count) fail(fmt::format("expected {} parts, got {}", count, all.size()));
    return all;
  }

  void read_key(std::string_view line) {
    const std::size_t at = line.find(": ");
    if (at == std::string_view::npos) fail("expected \"# key: value\"");
    const std::string_view key = line.substr(0, at);
    const std::string value(line.substr(at + 2));
    if (key == "job") {
      result_.job = value;
    } else if (key == "error") {
      result_.error_unit = value;
    } else if (key == "bound") {
      result_.bound_name = value;
    } else if (key == "failure") {
      result_.failure = value;
    } else if (key == "seed") {
      result_.seed = number<std::uint64_t>(value);
    } else if (key == "quick") {
      result_.quick = number<int>(value) != 0;
    } else if (key == "trials") {
      result_.num_trials = number<int>(value);
    } else if (key == "origin") {
      result_.origin.push_back(value);
    } else {
      read_part(key, value);
    }
  }

  void read_part(std::string_view key, const std::string& value) {
    if (key == "shard") {
      const auto p = parts(value, 2, "/");
      result_.shards.push_back({number<int>(p[0]), number<int>(p[1])});
    } else if (key == "method") {
      const auto p = parts(value, 3, kBetween);
      result_.methods.push_back({std::string(p[1]), std::string(p[2]), number<int>(p[0]) != 0});
    } else if (key == "panel") {
      const auto p = parts(value, 3, kBetween);
      result_.panels.push_back({std::string(p[0]), std::string(p[1]), std::string(p[2]), {}});
    } else if (key == "cannot" && !result_.panels.empty()) {
      result_.panels.back().cannot.push_back(value);
    } else {
      fail(fmt::format("unknown key {}", key));
    }
  }

  void read_trial(std::string_view line) {
    const auto p = parts(line, 6, ",");
    ChartTrial trial;
    trial.panel = number<int>(p[0]);
    trial.method = number<int>(p[1]);
    trial.trial = number<int>(p[2]);
    trial.time_us = number<double>(p[3]);
    trial.failed = p[4].empty() && p[5].empty();
    if (!trial.failed) trial.error = number<double>(p[4]), trial.over_bound = number<double>(p[5]);
    if (trial.panel < 0 || trial.panel >= static_cast<int>(result_.panels.size()))
      fail(fmt::format("there is no panel {}", trial.panel));
    if (trial.method < 0 || trial.method >= static_cast<int>(result_.methods.size()))
      fail(fmt::format("there is no method {}", trial.method));
    if (trial.trial < 0 || trial.trial >= result_.num_trials)
      fail(fmt::format("there is no trial {}", trial.trial));
    result_.trials.push_back(trial);
  }

  std::string_view text_;
  const std::string& name_;
  int line_ = 0;
  ChartResult result_;
};

}  // namespace

std::string trials_text(const ChartResult& result) {
  std::string text = fmt::format(
      "{}\n# job: {}\n# error: {}\n# bound: {}\n# failure: {}\n# seed: {}\n# quick: {}\n# trials: "
      "{}\n",
      kFirstLine, result.job, result.error_unit, result.bound_name, result.failure, result.seed,
      result.quick ? 1 : 0, result.num_trials);
  for (const Shard& s : result.shards) text += fmt::format("# shard: {}/{}\n", s.index, s.count);
  for (const std::string& line : result.origin) text += fmt::format("# origin: {}\n", line);
  for (const ChartMethod& m : result.methods)
    text += fmt::format("# method: {} | {} | {}\n", m.ours ? 1 : 0, m.name, m.settings);
  for (const ChartPanel& p : result.panels) {
    text += fmt::format("# panel: {} | {} | {}\n", p.page, p.row, p.column);
    for (const std::string& why : p.cannot) text += fmt::format("# cannot: {}\n", why);
  }
  text += fmt::format("{}\n", kHeader);
  for (const ChartTrial& t : result.trials) {
    text += fmt::format("{},{},{},{:.5g},", t.panel, t.method, t.trial, t.time_us);
    text += t.failed ? std::string(",\n") : fmt::format("{},{}\n", t.error, t.over_bound);
  }
  return text;
}

ChartResult read_trials(std::string_view text, const std::string& name) {
  return TrialsReader(text, name).read();
}

std::string points_csv(const ChartResult& result, std::span<const ChartPoint> points) {
  std::string text = "job,method,panel,time_us,rms,rms_over_bound,failures,trials\n";
  const auto number = [](double v) { return std::isfinite(v) ? fmt::format("{:.6g}", v) : ""; };
  for (const ChartPoint& p : points)
    text += fmt::format("{},{},{},{:.4g},{},{},{},{}\n", result.job,
                        field(result.methods[static_cast<std::size_t>(p.method)].name),
                        field(result.panels[static_cast<std::size_t>(p.panel)].name()),
                        p.time_us.median, number(p.rms), number(p.rms_over_bound), p.failures,
                        p.trials);
  return text;
}

}  // namespace tagcal
