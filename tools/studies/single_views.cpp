// Calibrates single views of real data sets, or random groups of a few, and compares their focal
// length fx with the answer of all views of the set: z is the difference in units of the standard
// deviation that both claim.
//   single_views DATASET... [--views N [--groups N]] [--truth FX] [--model NAME] [--seed N]
//                [--threads N] [--csv FILE]
// Refused: no answer, or the answer `weak`. No answer may claim an sd(fx) / fx above 10 %.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <optional>

#include "real/real_sets.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal {
namespace {

struct Options : RealOptions {
  std::size_t views = 1;    // of a group
  std::size_t groups = 20;  // of a set, if they have more than one view
  double truth_px = 0;      // 0: the answer of all views
};

// A calibration of some views of a set.
struct Group {
  std::size_t set = 0;
  std::vector<std::size_t> views;
  std::string outcome;
  std::optional<Claim> focal;  // without a value: refused
};

void calibrate_group(const RealSet& set, const Options& options, Group& group) {
  const Calibration c = calibrate_views(set.dataset, group.views, options.model);
  group.outcome = outcome(c);
  if (has_focal_length(c)) group.focal = claim_of(c, 0);
}

// The groups of all sets. The first one of a set has all of its views.
std::vector<Group> groups_of(const std::vector<RealSet>& sets, const Options& options) {
  std::vector<Group> groups;
  for (std::size_t s = 0; s < sets.size(); ++s) {
    const std::size_t n = sets[s].dataset.views.size();
    Random random(options.seed);
    const auto add = [&](std::vector<std::size_t> views) {
      groups.push_back({s, std::move(views), {}, {}});
    };
    add(random_subset(n, n, random));
    if (options.views == 1)
      for (std::size_t i = 0; i < n; ++i) add({i});
    else if (options.views <= n)
      for (std::size_t i = 0; i < options.groups; ++i) add(random_subset(n, options.views, random));
  }
  return groups;
}

struct Sums {
  int groups = 0, refused = 0, too_wide = 0;
  Scores focal;
  std::vector<double> error_percent, sd_percent;

  void add(const Group& group, const std::optional<Claim>& truth);
  void add(const Sums& other);
};

void Sums::add(const Group& group, const std::optional<Claim>& truth) {
  ++groups;
  refused += !group.focal;
  if (!group.focal) return;
  const double sd = percent(group.focal->sd, group.focal->value);
  sd_percent.push_back(sd);
  too_wide += !(sd <= 10);
  if (!truth) return;
  focal.add(z_of(*group.focal, *truth));
  error_percent.push_back(percent(std::abs(group.focal->value - truth->value), truth->value));
}

void Sums::add(const Sums& other) {
  groups += other.groups;
  refused += other.refused;
  too_wide += other.too_wide;
  focal.add(other.focal);
  error_percent.insert(error_percent.end(), other.error_percent.begin(), other.error_percent.end());
  sd_percent.insert(sd_percent.end(), other.sd_percent.begin(), other.sd_percent.end());
}

double median_or_zero(const std::vector<double>& values) {
  return values.empty() ? 0 : internal::median(values);
}

void print(const std::string& name, const Sums& s, const std::string& reference) {
  fmt::print("{:16}{:7}{:6}{:8}{:7}{:6}{:7.2f}{:7.1f}{:9.2f}{:10.2f}  {}\n", name.substr(0, 16),
             s.groups, s.groups - s.refused, s.refused, s.too_wide, s.focal.beyond(), s.focal.rms(),
             s.focal.worst(), median_or_zero(s.error_percent), median_or_zero(s.sd_percent),
             reference);
}

std::string csv_line(const RealSet& set, const Group& group, const std::optional<Claim>& truth) {
  std::string views;
  for (const std::size_t v : group.views) views += (views.empty() ? "" : " ") + std::to_string(v);
  const Claim focal = group.focal.value_or(Claim{NAN, NAN});
  const Claim of_all = truth.value_or(Claim{NAN, NAN});
  return fmt::format("{},{},{},{},{},{},{}\n", set.name, views, group.outcome, focal.value,
                     focal.sd, of_all.value, of_all.sd);
}

int run(const Options& options) {
  const std::vector<RealSet> sets = read_sets(options.folders);
  std::vector<Group> groups = groups_of(sets, options);
  internal::parallel_for(groups.size(), options.threads, [&](std::size_t i) {
    calibrate_group(sets[groups[i].set], options, groups[i]);
  });
  fmt::print("{:16}{:>7}{:>6}{:>8}{:>7}{:>6}{:>7}{:>7}{:>9}{:>10}  {}\n", "set", "groups", "ok",
             "refused", ">10 %", "|z|>3", "rms z", "worst", "error, %", "sd, %", "compared with");
  std::string csv = "set,views,outcome,fx,sd_fx,fx_all,sd_fx_all\n";
  Sums all;
  for (std::size_t i = 0; i < groups.size();) {
    const Group& whole = groups[i];
    const RealSet& set = sets[whole.set];
    std::optional<Claim> truth = whole.focal;
    if (options.truth_px > 0) truth = Claim{options.truth_px, 0};
    Sums of_set;
    for (++i; i < groups.size() && groups[i].set == whole.set; ++i) {
      of_set.add(groups[i], truth);
      csv += csv_line(set, groups[i], truth);
    }
    print(set.name, of_set,
          truth ? fmt::format("{:.2f} +- {:.2f}", truth->value, truth->sd) : whole.outcome);
    all.add(of_set);
  }
  print("all sets", all, "");
  if (!options.csv.empty()) write_whole(options.csv, csv);
  return 0;
}

int command(int argc, char** argv) {
  Options options;
  CLI::App app("Compares calibrations of single views of real data sets with those of all views.");
  add_options(app, options);
  app.add_option("--views", options.views, "in each calibration (1)")->check(CLI::Range(1, 100000));
  app.add_option("--groups", options.groups, "random groups of a set, with --views 2 or more (20)");
  app.add_option("--truth", options.truth_px, "the true fx of all sets, px");
  CLI11_PARSE(app, argc, argv);
  return run(options);
}

}  // namespace
}  // namespace tagcal

int main(int argc, char** argv) {
  try {
    return tagcal::command(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "single_views: {}\n", error.what());
    return 2;
  }
}
