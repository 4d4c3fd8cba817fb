// Compares the calibrations of two random halves of the views of real data sets, and tests their
// claims: z is a difference in units of the standard deviation that both claims predict.
//   halves DATASET... [--splits N] [--model NAME] [--seed N] [--threads N] [--csv FILE]
// The projections are compared at infinity, less a rotation, over the region of the corners of the
// whole set. `region` takes the claims at the nodes of a grid in this region; `printed` takes the
// RMS claims that the calibrations print, each over the region of its own half.
// Refused: no answer, or the answer `weak`.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "real/real_sets.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal {
namespace {

constexpr std::array<std::size_t, 3> kCompared = {0, 2, 3};  // fx, cx, cy

struct Split {
  std::array<std::string, 2> outcomes;
  int refused = 0;
  std::array<Claim, 3> a, b;                 // of kCompared, if none is refused
  std::optional<ProjectionTest> projection;  // without a value: cannot be compared
};

Split split_of(const RealSet& set, const SeenRegion& region, const RealOptions& options,
               std::uint64_t index) {
  Random random(options.seed, index);
  const std::size_t n = set.dataset.views.size();
  const std::vector<std::size_t> first = random_subset(n, n / 2, random);
  std::vector<std::size_t> second;
  for (std::size_t i = 0; i < n; ++i)
    if (!std::ranges::binary_search(first, i)) second.push_back(i);
  const Calibration a = calibrate_views(set.dataset, first, options.model);
  const Calibration b = calibrate_views(set.dataset, second, options.model);
  Split split{{outcome(a), outcome(b)}, !has_focal_length(a) + !has_focal_length(b), {}, {}, {}};
  if (split.refused > 0) return split;
  for (std::size_t i = 0; i < kCompared.size(); ++i) {
    split.a[i] = claim_of(a, kCompared[i]);
    split.b[i] = claim_of(b, kCompared[i]);
  }
  split.projection = test_projection(a, b, region);
  return split;
}

struct Sums {
  int splits = 0, refused = 0;
  std::array<Scores, 3> parameters;
  Scores region, printed;
  std::vector<double> focal_percent, claim_percent;  // differences of fx, and their claims
  std::map<std::string, int> outcomes;

  void add(const Split& split);
  void add(const Sums& other);
  Scores all_parameters() const {
    Scores all;
    for (const Scores& s : parameters) all.add(s);
    return all;
  }
};

void Sums::add(const Split& split) {
  ++splits;
  refused += split.refused;
  for (const std::string& o : split.outcomes) ++outcomes[o];
  if (split.refused > 0) return;
  for (std::size_t i = 0; i < kCompared.size(); ++i) {
    const Claim &a = split.a[i], &b = split.b[i];
    if (a.sd > 0 || b.sd > 0) parameters[i].add(z_of(a, b));  // not what both hold at one value
  }
  // Lenses that cannot be compared count as infinitely different.
  const ProjectionTest test = split.projection.value_or(ProjectionTest{HUGE_VAL, 1, 1});
  region.add(test.difference_px / test.claim_px);
  printed.add(test.difference_px / test.printed_px);
  const Claim &a = split.a[0], &b = split.b[0];
  const double mean = (a.value + b.value) / 2;
  focal_percent.push_back(percent(a.value - b.value, mean));
  claim_percent.push_back(percent(std::hypot(a.sd, b.sd), mean));
}

void Sums::add(const Sums& other) {
  splits += other.splits;
  refused += other.refused;
  for (std::size_t i = 0; i < parameters.size(); ++i) parameters[i].add(other.parameters[i]);
  region.add(other.region);
  printed.add(other.printed);
}

void print_set(const RealSet& set, const Sums& s) {
  std::string outcomes;
  for (const auto& [name, count] : s.outcomes) outcomes += fmt::format(" {} {}", name, count);
  fmt::print("{:16}{:6}{:7}{:8}  {}  {} {:7.2f} {:6.2f} {}\n", set.name.substr(0, 16),
             set.dataset.views.size(), s.splits, s.refused, s.all_parameters().text(),
             s.region.text(), rms_of(s.focal_percent), rms_of(s.claim_percent), outcomes);
}

void print_totals(const Sums& s) {
  fmt::print("\n{:16}{:>6}{:>7} {:>6} {:>7}\n", "all sets", "count", "rms", ">3 %", "worst");
  const auto line = [](const char* name, const Scores& scores) {
    fmt::print("{:16}{:6} {}\n", name, scores.count(), scores.text());
  };
  line("fx", s.parameters[0]);
  line("cx", s.parameters[1]);
  line("cy", s.parameters[2]);
  line("fx, cx, cy", s.all_parameters());
  line("region", s.region);
  line("region, printed", s.printed);
  fmt::print("refused: {} of {} halves, {:.1f} %\n", s.refused, 2 * s.splits,
             percent(s.refused, 2 * s.splits));
}

std::string csv_line(const RealSet& set, std::size_t index, const Split& split) {
  std::string line =
      fmt::format("{},{},{},{}", set.name, index, split.outcomes[0], split.outcomes[1]);
  if (split.refused > 0) return line + std::string(15, ',') + "\n";
  for (std::size_t i = 0; i < kCompared.size(); ++i)
    line += fmt::format(",{},{},{},{}", split.a[i].value, split.a[i].sd, split.b[i].value,
                        split.b[i].sd);
  if (!split.projection) return line + ",,,\n";
  const ProjectionTest& p = *split.projection;
  return line + fmt::format(",{},{},{}\n", p.difference_px, p.claim_px, p.printed_px);
}

int run(const RealOptions& options, std::size_t splits) {
  const std::vector<RealSet> sets = read_sets(options.folders);
  std::vector<Split> results(sets.size() * splits);
  internal::parallel_for(results.size(), options.threads, [&](std::size_t i) {
    const RealSet& set = sets[i / splits];
    results[i] = split_of(set, region_of(set.dataset), options, i % splits);
  });
  std::string csv = "set,split,outcome_a,outcome_b";
  for (const char* p : {"fx", "cx", "cy"}) csv += fmt::format(",{0}_a,sd_{0}_a,{0}_b,sd_{0}_b", p);
  csv += ",difference_px,claim_px,printed_px\n";
  fmt::print("{:37}  z of fx, cx, cy{:8}z of the region{:8}fx, % rms\n", "", "", "");
  fmt::print("{:16}{:>6}{:>7}{:>8} {:>7} {:>6} {:>7} {:>7} {:>6} {:>7} {:>7} {:>6}  {}\n", "set",
             "views", "splits", "refused", "rms", ">3 %", "worst", "rms", ">3 %", "worst", "differ",
             "claim", "halves");
  Sums all;
  for (std::size_t i = 0; i < sets.size(); ++i) {
    Sums of_set;
    for (std::size_t k = 0; k < splits; ++k) {
      of_set.add(results[i * splits + k]);
      csv += csv_line(sets[i], k, results[i * splits + k]);
    }
    print_set(sets[i], of_set);
    all.add(of_set);
  }
  print_totals(all);
  if (!options.csv.empty()) write_whole(options.csv, csv);
  return 0;
}

int command(int argc, char** argv) {
  RealOptions options;
  std::size_t splits = 8;
  CLI::App app("Compares calibrations of random halves of the views of real data sets.");
  add_options(app, options);
  app.add_option("--splits", splits, "of each data set (8)")->check(CLI::Range(1, 100000));
  CLI11_PARSE(app, argc, argv);
  return run(options, splits);
}

}  // namespace
}  // namespace tagcal

int main(int argc, char** argv) {
  try {
    return tagcal::command(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "halves: {}\n", error.what());
    return 2;
  }
}
