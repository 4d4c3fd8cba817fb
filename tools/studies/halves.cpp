// Compares the calibrations of two halves of the views of real data sets, and tests their claims:
// random halves, and halves of views that follow one another, which share their errors: z is a
// difference in units of the standard deviation that both claims predict. The projections are
// compared at infinity, less a rotation, over the region of the corners of the whole set. `region`
// takes the claims at the nodes of a grid in this region; `printed` takes the RMS claims that the
// calibrations print, each over the region of its own half. `check` tests the camera of the first
// half by the views of the second, which nothing changed. Refused: no answer, or the answer `weak`.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "real_sets.hpp"
#include "studies/studies.hpp"
#include "study/tasks/pose_tasks.hpp"
#include "tagcal/estimate/check_camera.hpp"

namespace tagcal {
using namespace study;
namespace {

constexpr std::array<std::size_t, 3> kCompared = {0, 2, 3};  // fx, cx, cy
constexpr std::size_t kNumColumns = 26;

void add_parameters(const Calibration& a, const Calibration& b, Values& row, Values& scores) {
  for (const std::size_t i : kCompared) {
    const Claim of_a = claim_of(a, i), of_b = claim_of(b, i);
    for (const double v : {of_a.value, of_a.sd, of_b.value, of_b.sd}) row.emplace_back(v);
    const bool held = !(of_a.sd > 0 || of_b.sd > 0);  // both at one value
    scores.emplace_back(held ? std::nan("") : z_of(of_a, of_b));
  }
  const Claim of_a = claim_of(a, 0), of_b = claim_of(b, 0);
  const double mean = (of_a.value + of_b.value) / 2;
  scores.emplace_back(100 * (of_a.value - of_b.value) / mean);
  scores.emplace_back(100 * std::hypot(of_a.sd, of_b.sd) / mean);
}

// Lenses that cannot be compared count as infinitely different.
void add_projection(const Calibration& a, const Calibration& b, const SeenRegion& region,
                    Values& row, Values& scores) {
  const auto test = test_projection(a, b, region);
  const double none = std::nan("");
  for (const double v : {test ? test->difference_px : none, test ? test->claim_px : none,
                         test ? test->printed_px : none})
    row.emplace_back(v);
  scores.emplace_back(test ? test->difference_px / test->claim_px : HUGE_VAL);
  scores.emplace_back(test ? test->difference_px / test->printed_px : HUGE_VAL);
}

std::vector<std::size_t> random_half(std::size_t n, const StudyOptions& options,
                                     std::uint64_t split) {
  Random random(static_cast<std::uint64_t>(options.number("seed")), split);
  return some_of(n, n / 2, random);
}

// Half of the views, which follow one another; after the last comes the first.
std::vector<std::size_t> half_in_time(std::size_t n, std::uint64_t split) {
  constexpr std::size_t kSplits = 4;  // numeric: later ones are these, exchanged
  std::vector<std::size_t> half;
  for (std::size_t i = 0; i < n / 2; ++i)
    half.push_back((static_cast<std::size_t>(split) * n / (2 * kSplits) + i) % n);
  std::ranges::sort(half);
  return half;
}

std::vector<Values> measure(const RealSet& set, const StudyOptions& options,
                            const std::vector<std::size_t>& first) {
  const std::size_t n = set.dataset.views.size();
  std::vector<std::size_t> second;
  for (std::size_t i = 0; i < n; ++i)
    if (!std::ranges::binary_search(first, i)) second.push_back(i);
  const Calibration a = calibrate_views(set.dataset, first, options.text("model"));
  const Calibration b = calibrate_views(set.dataset, second, options.text("model"));
  std::string check;
  if (is_answer(a.status) && a.claim && a.claim->model)
    check = verdict_name(check_camera(part_of(set.dataset, second), *a.claim).verdict);
  const int refused = !has_focal_length(a) + !has_focal_length(b);
  Values row = {outcome(a), outcome(b)}, scores = {static_cast<double>(refused)};
  if (refused == 0) {
    add_parameters(a, b, row, scores);
    add_projection(a, b, region_of(set.dataset), row, scores);
  } else {
    row.resize(2 + 4 * kCompared.size() + 3, std::nan(""));
  }
  row.insert(row.end(), scores.begin(), scores.end());
  row.resize(kNumColumns - 1, std::nan(""));
  row.emplace_back(check);
  return {row};
}

std::vector<Task> halves_tasks(const StudyOptions& options) {
  std::vector<Task> tasks;
  for (RealSet& read : read_sets(options.inputs)) {
    const auto set = std::make_shared<const RealSet>(std::move(read));
    const std::size_t n = set->dataset.views.size();
    tasks.push_back({set->name, [=](std::uint64_t split) {
                       return measure(*set, options, random_half(n, options, split));
                     }});
    tasks.push_back({set->name + ", in time", [=](std::uint64_t split) {
                       return measure(*set, options, half_in_time(n, split));
                     }});
  }
  return tasks;
}

// RMS, percentage beyond 3 and the largest of the z in some columns.
Figure z_figure(const std::string& heading, const std::vector<std::string>& columns) {
  return {heading + ": rms, > 3, largest", [=](const Sample& sample) {
            int n = 0, beyond = 0;
            double squares = 0, largest = 0;
            for (const std::string& column : columns)
              for (const double z : sample.numbers(column)) {
                ++n, squares += z * z, beyond += !(std::abs(z) <= 3);
                largest = std::max(largest, std::abs(z));
              }
            if (n == 0) return std::string();
            return fmt::format("{:.2f}, {:.1f} %, {:.1f}", std::sqrt(squares / n),
                               100.0 * beyond / n, largest);
          }};
}

}  // namespace

Study halves_study() {
  const std::vector<Figure> figures = {rows_in("splits"),
                                       sum_of("halves refused", "refused"),
                                       z_figure("fx, cx, cy", {"z_fx", "z_cx", "z_cy"}),
                                       z_figure("region", {"z_region"}),
                                       z_figure("region, printed", {"z_printed"}),
                                       z_figure("fx", {"z_fx"}),
                                       z_figure("cx", {"z_cx"}),
                                       z_figure("cy", {"z_cy"}),
                                       rms_of("fx differs, %", "fx_percent", 2),
                                       rms_of("its claim, %", "claim_percent", 2),
                                       counts_of("first halves", "outcome_a"),
                                       counts_of("second halves", "outcome_b"),
                                       counts_of("check of the second by the first", "check")};
  return {.name = "halves",
          .summary = "calibrations of halves of the views of real data sets",
          .inputs = "folders of data sets",
          .count = 8,
          .first = 0,
          .options = {{"model", "auto", "of all calibrations"}, {"seed", "1", "of the halves"}},
          .columns = {"outcome_a", "outcome_b",  "fx_a",          "sd_fx_a",  "fx_b",
                      "sd_fx_b",   "cx_a",       "sd_cx_a",       "cx_b",     "sd_cx_b",
                      "cy_a",      "sd_cy_a",    "cy_b",          "sd_cy_b",  "difference_px",
                      "claim_px",  "printed_px", "refused",       "z_fx",     "z_cx",
                      "z_cy",      "fx_percent", "claim_percent", "z_region", "z_printed",
                      "check"},
          .tasks = halves_tasks,
          .tables = {{{"task"}, figures}, {{}, figures}}};
}

}  // namespace tagcal
