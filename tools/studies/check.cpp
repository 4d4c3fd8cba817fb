// The check of a camera by new pictures, and a threshold of their RMS residual by the known camera
// at equal false alarms, as programs have it that warn of a large mean reprojection error
// (docs/trust/how_sure.md).
// A calibrated camera (opencv5), 2 to 10 new pictures, unchanged or after the smallest change of
// the focal length or of the principal point that the check says it shows, and twice that.

#include <fmt/format.h>

#include <cmath>

#include "check_worlds.hpp"
#include "studies/studies.hpp"
#include "study/quantile.hpp"

namespace tagcal {
using namespace study;
namespace {

struct Noise {
  const char* name;
  double least_px, most_px;
};

// True if a kind is named, or one of those that explain the pictures as well.
bool explains(const CameraChange& change, ChangeKind kind) {
  return change.kind == kind || std::ranges::count(change.as_well, kind, &ChangedPart::kind) > 0;
}

std::vector<Values> measure_check(const Noise& noise, std::uint64_t seed) {
  std::vector<Values> rows;
  for (const int num_views : {2, 5, 10}) {
    Random random(seed, static_cast<std::uint64_t>(num_views));
    const UncertainCamera known = calibrated(opencv5_lens(), random);
    WorldOptions options;
    options.num_views = num_views;
    options.sigma_px = random.uniform(noise.least_px, noise.most_px);
    const ChangeKind kind =
        random.uniform() < 0.5 ? ChangeKind::focal_length : ChangeKind::principal_point;
    const double sign = random.uniform() < 0.5 ? -1 : 1;
    const Dataset world = make_world(opencv5_lens(), seed, options);
    const CameraCheck still = check_camera(world, known);
    const auto add = [&](double times, const CameraCheck& check) {
      const auto stated = std::ranges::find(still.detectable, kind, &DetectableChange::kind);
      rows.push_back({static_cast<double>(num_views), times,
                      check.verdict == CheckVerdict::changed ? 1.0 : 0.0,
                      check.cameras[0].known_rms_px, times * stated->max_px,
                      check.change && check.change->kind == kind ? 1.0 : 0.0,
                      check.change && explains(*check.change, kind) ? 1.0 : 0.0});
    };
    add(0, still);
    for (const double times : {1.0, 2.0})
      add(times, check_camera(taken_by(changed_lens(still, kind, sign * times), world), known));
  }
  return rows;
}

// The share in percent of the rows with a change of `times` for which `is_found(row)`.
template <typename F>
std::string share_of(const Sample& sample, double times, const F& is_found) {
  const std::vector<double> of_row = sample.numbers("times");
  int count = 0, found = 0;
  for (std::size_t i = 0; i < of_row.size(); ++i) {
    if (of_row[i] != times) continue;
    ++count;
    found += is_found(i);
  }
  return fmt::format("{:.1f} %", 100.0 * found / std::max(1, count));
}

// The RMS that a share of unchanged cameras exceeds, that of a false alarm of the check.
double rms_threshold(const Sample& sample) {
  const std::vector<double> times = sample.numbers("times"), rms = sample.numbers("rms");
  std::vector<double> unchanged;
  for (std::size_t i = 0; i < rms.size(); ++i)
    if (times[i] == 0) unchanged.push_back(rms[i]);
  constexpr double kQuiet = 0.99;
  return quantile(unchanged, kQuiet);
}

// The share of the changes of `times` whose column is 1.
Figure share_with(const std::string& heading, const std::string& column, double times) {
  return {heading, [column, times](const Sample& sample) {
            const std::vector<double> values = sample.numbers(column);
            return share_of(sample, times, [&](std::size_t i) { return values[i] > 0; });
          }};
}

Figure found_by_rms(const std::string& heading, double times) {
  return {heading, [times](const Sample& sample) {
            const std::vector<double> rms = sample.numbers("rms");
            const double bound = rms_threshold(sample);
            return share_of(sample, times, [&](std::size_t i) { return rms[i] > bound; });
          }};
}

Figure stated_size() {
  return {"stated change, median", [](const Sample& sample) {
            const std::vector<double> times = sample.numbers("times"), px = sample.numbers("px");
            std::vector<double> stated;
            for (std::size_t i = 0; i < px.size(); ++i)
              if (times[i] == 1) stated.push_back(px[i]);
            return fmt::format("{:.2f} px", quantile(stated, 0.5));
          }};
}

}  // namespace

Study check_study() {
  return {
      .name = "check",
      .summary = "changed cameras: what a check finds, and a threshold of the RMS residual",
      .count = 1000,
      .columns = {"pictures", "times", "found", "rms", "px", "named", "explained"},
      .tasks =
          [](const StudyOptions&) {
            std::vector<study::Task> tasks;
            for (const Noise& noise :
                 {Noise{"noise 0.2 px", 0.2, 0.2}, Noise{"noise 0.1 to 0.3 px", 0.1, 0.3}})
              tasks.push_back(
                  {noise.name, [noise](std::uint64_t seed) { return measure_check(noise, seed); }});
            return tasks;
          },
      .tables = {{{"task", "pictures"},
                  {stated_size(), share_with("check, unchanged", "found", 0),
                   share_with("stated change", "found", 1), share_with("twice that", "found", 2),
                   found_by_rms("RMS, unchanged", 0), found_by_rms("stated change", 1),
                   found_by_rms("twice that", 2)}},
                 {{"task", "pictures"},
                  {share_with("named", "named", 2), share_with("or as well", "explained", 2)}}}};
}

}  // namespace tagcal
