// Counts the findings of calibrations of good and of bad data sets (docs/trust/how_sure.md).
//   warnings [SETS, default 500 [FIRST_SEED, default 1]]
// Good sets are calibrated with the model that made them and with `auto`. Bad sets have a board
// that is bent by 0.5 mm, or are calibrated with a model that is one step too small.

#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "random_lens.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/findings.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

// The columns of the table.
constexpr std::array<std::pair<const char*, internal::FindingCode>, 9> kKinds = {
    {{"halves", internal::code::halves_disagree},
     {"bent", internal::code::board_bent},
     {"field", internal::code::residuals_biased},
     {"small", internal::code::model_too_small},
     {"target", internal::code::tags_misplaced},
     {"outliers", internal::code::corners_rejected},
     {"weak", internal::code::direction_weak},
     {"trade", internal::code::coefficients_correlated},
     {"gap", internal::code::extrapolated}}};
constexpr std::array<const char*, 4> kOfModel = {"halves", "bent", "field", "small"};

// The column "gap" counts parts of the image without corners, not extrapolation beyond the corners
// alone.
bool is_of_kind(const Finding& finding, const internal::FindingCode& code, const Calibration& c) {
  if (finding.code != code.name) return false;
  return code.name != internal::code::extrapolated.name || c.seen.gaps();
}

struct Counts {
  int sets = 0;
  int answers = 0;
  std::map<std::string, int> warned;  // by kind; "model error": sets with any of kOfModel
};

void count(const Calibration& c, Counts& counts) {
  ++counts.sets;
  counts.answers += is_answer(c.status);
  std::map<std::string, bool> seen;
  for (const Finding& finding : c.findings)
    for (const auto& [kind, code] : kKinds)
      if (is_of_kind(finding, code, c)) seen[kind] = true;
  for (const char* kind : kOfModel) seen["model error"] |= seen[kind];
  for (const auto& [kind, yes] : seen) counts.warned[kind] += yes;
}

void print(const std::string& name, const Counts& counts) {
  std::printf("%-34s %5d %7d %7d", name.c_str(), counts.sets, counts.answers,
              counts.warned.contains("model error") ? counts.warned.at("model error") : 0);
  for (const auto& [kind, code] : kKinds)
    std::printf(" %8d", counts.warned.contains(kind) ? counts.warned.at(kind) : 0);
  std::printf("\n");
  std::fflush(stdout);
}

Calibration calibrated(const Dataset& set, const std::string& model) {
  CalibrateOptions options;
  options.model = model;
  return calibrate(set, options);
}

// The same poses with a board whose middle line stands out of its plane by `bend_m`.
Dataset bent(const Lens& lens, std::uint64_t seed, const WorldOptions& options, double bend_m) {
  Dataset set = make_world(lens, seed, options);
  std::map<CornerId, Eigen::Vector3d> points;
  for (const TargetPoint& p : target_points(set.boards[0].board)) points[p.id] = p.position;
  double half = 0;
  for (const auto& [id, x] : points) half = std::max(half, 0.5 * x.x());
  Random random(seed, 99);
  for (View& view : set.views) {
    const Pose& pose = set.truth->camera_from_world.at(view.image);
    for (Observation& o : view.observations) {
      Eigen::Vector3d x = points.at(o.id);
      const double across = x.x() / half - 1;
      x.z() += bend_m * (1 - across * across);
      o.pixel = project(lens, pose * x).value_or(o.pixel) +
                options.sigma_px * Eigen::Vector2d(random.normal(), random.normal());
    }
  }
  return set;
}

}  // namespace
}  // namespace tagcal

int main(int argc, char** argv) {
  using namespace tagcal;
  const int wanted = argc > 1 ? std::atoi(argv[1]) : 500;
  const int first = argc > 2 ? std::atoi(argv[2]) : 1;
  Counts good, good_auto, exact, bowed, bowed_auto;
  std::map<std::string, Counts> small;
  for (int seed = first; seed < first + wanted; ++seed) {
    LensWorld world(static_cast<std::uint64_t>(seed));
    world.options.sigma_px = 0.1 + 0.4 * world.random.uniform();
    const Dataset set = world.make();
    count(calibrated(set, world.model), good);
    count(calibrated(set, "auto"), good_auto);
    const std::string below = model_below(world.model);
    if (!below.empty() && world.needs_model(set))
      count(calibrated(set, below), small[below + " for " + world.model]);
    WorldOptions bow = world.options;
    const Dataset curved = bent(world.lens, world.seed, bow, 5e-4);
    count(calibrated(curved, world.model), bowed);
    count(calibrated(curved, "auto"), bowed_auto);
    world.options.sigma_px = 0;
    count(calibrated(world.make(), world.model), exact);
  }
  std::printf("%-34s %5s %7s %7s", "sets", "", "answers", "error");
  for (const auto& [kind, code] : kKinds) std::printf(" %8s", kind);
  std::printf("\n");
  print("good, the model by name", good);
  print("good, auto", good_auto);
  print("exact corners, by name", exact);
  print("bent by 0.5 mm, by name", bowed);
  print("bent by 0.5 mm, auto", bowed_auto);
  for (const auto& [name, counts] : small) print(name, counts);
}
