// How often calibrations warn without and with reason. Usage: warnings [SETS [FIRST_SEED]]
// Good sets (the model that made the data, and `auto`): every warning is counted. Bad ones: boards
// that are bent by 0.5 mm, and a model that is one or more steps too small.

#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "random_lens.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

constexpr std::array<std::pair<const char*, const char*>, 10> kKinds = {
    {{"halves", "two halves"},
     {"bent", "bent board better"},
     {"field", "from place to place"},
     {"small", "too small: opencv5"},
     {"target", "the target is not as its file says"},
     {"outliers", "were left out"},
     {"weak", "at infinity)"},
     {"focal", "weakly known"},
     {"trade", "trade with one another"},
     {"gap", "of the image: the lens"}}};
constexpr std::array<const char*, 4> kOfModel = {"halves", "bent", "field", "small"};

struct Counts {
  int sets = 0;
  int answers = 0;
  std::map<std::string, int> warned;  // per kind; "model error": any of those
};

void count(const Calibration& c, Counts& counts) {
  ++counts.sets;
  counts.answers += is_answer(c.status);
  std::map<std::string, bool> seen;
  for (const std::string& warning : c.warnings)
    for (const auto& [kind, text] : kKinds)
      if (warning.find(text) != std::string::npos) seen[kind] = true;
  for (const char* kind : kOfModel) seen["model error"] |= seen[kind];
  for (const auto& [kind, yes] : seen) counts.warned[kind] += yes;
}

void print(const std::string& name, const Counts& counts) {
  std::printf("%-34s %5d %7d %7d", name.c_str(), counts.sets, counts.answers,
              counts.warned.contains("model error") ? counts.warned.at("model error") : 0);
  for (const auto& [kind, text] : kKinds)
    std::printf(" %8d", counts.warned.contains(kind) ? counts.warned.at(kind) : 0);
  std::printf("\n");
  std::fflush(stdout);
}

Calibration calibrated(const Dataset& set, const std::string& model) {
  CalibrateOptions options;
  options.model = model;
  return calibrate(set, options);
}

// Corners of a board that stands out by as much in its middle, where the flat one's were.
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
  for (const auto& [kind, text] : kKinds) std::printf(" %8s", kind);
  std::printf("\n");
  print("good, the model by name", good);
  print("good, auto", good_auto);
  print("exact corners, by name", exact);
  print("bent by 0.5 mm, by name", bowed);
  print("bent by 0.5 mm, auto", bowed_auto);
  for (const auto& [name, counts] : small) print(name, counts);
}
