// Compares the model that `auto` chooses with the one that made the data (docs/trust/how_sure.md).
//   model_confusion [SETS, default 500 [FIRST_SEED, default 1]]
// A set counts if its model is needed (LensWorld::needs_model). Two tables: lenses as drawn, and
// lenses whose last step is scaled by a factor of 0.01 to 1.

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "random_lens.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal {
namespace {

int order(const std::string& model) {
  for (std::size_t i = 0; i < kModels.size(); ++i)
    if (model == kModels[i]) return static_cast<int>(i);
  return -1;
}

void print(const std::map<std::string, std::map<std::string, int>>& table) {
  std::printf("%-10s", "truth");
  for (const char* model : kModels) std::printf("%9s", model);
  std::printf("%9s%9s\n", "weak", "refused");
  int all = 0, right = 0, larger = 0;
  for (const char* truth : kModels) {
    std::printf("%-10s", truth);
    const auto row = table.find(truth);
    for (const char* chosen : {"f", "f+c", "pinhole", "radial1", "radial2", "opencv4", "opencv5",
                               "opencv8", "fisheye4", "weak", "refused"}) {
      const int n =
          row == table.end() || !row->second.contains(chosen) ? 0 : row->second.at(chosen);
      std::printf("%9d", n);
      all += n;
      right += std::string(truth) == chosen ? n : 0;
      if (order(chosen) > order(truth)) larger += n;
    }
    std::printf("\n");
  }
  std::printf("sets %d, right %.1f %%, larger %.1f %%\n", all, 100.0 * right / all,
              100.0 * larger / all);
}

void explain_miss(const LensWorld& world, const Calibration& c) {
  std::fprintf(stderr, "seed %d sigma %.2f views %d: %s -> %s (%s)\n", static_cast<int>(world.seed),
               world.options.sigma_px, world.options.num_views, world.model.c_str(),
               c.model.c_str(), std::string(status_name(c.status)).c_str());
  for (const ModelStep& s : c.steps)
    std::fprintf(stderr, "   %-9s bic %.1f diff %.3f %s\n", s.model.c_str(), s.bic,
                 s.difference_px.value_or(-1), s.sentence.c_str());
}

void run(int wanted, int first_seed, bool small_steps) {
  std::map<std::string, std::map<std::string, int>> table;
  int counted = 0;
  for (int seed = first_seed; counted < wanted; ++seed) {
    const LensWorld world(static_cast<std::uint64_t>(seed), small_steps);
    const Dataset set = world.make();
    if (!world.needs_model(set)) continue;
    ++counted;
    const Calibration c = calibrate(set);
    const std::string chosen = is_answer(c.status) || c.model == "weak" ? c.model : "refused";
    ++table[world.model][chosen];
    if (chosen != world.model) explain_miss(world, c);
  }
  print(table);
}

}  // namespace
}  // namespace tagcal

int main(int argc, char** argv) {
  const int wanted = argc > 1 ? std::atoi(argv[1]) : 500;
  const int first_seed = argc > 2 ? std::atoi(argv[2]) : 1;
  tagcal::run(wanted, first_seed, false);
  tagcal::run(wanted, first_seed, true);
}
