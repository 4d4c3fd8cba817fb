// Compares the model that `auto` chooses with the one that made the data (docs/trust/how_sure.md).
// A set counts if its model is needed (LensWorld::needs_model). Two tasks: lenses as drawn, and
// lenses whose last step is scaled by a factor of 0.01 to 1.

#include <algorithm>

#include "random_lens.hpp"
#include "studies/studies.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal {
using namespace study;
namespace {

std::vector<Values> measure(std::uint64_t seed, bool small_steps) {
  const LensWorld world(seed, small_steps);
  const Dataset set = world.make();
  if (!world.needs_model(set)) return {};
  const Calibration c = calibrate(set);
  const std::string chosen = is_answer(c.status) || c.model == "weak" ? c.model : "refused";
  const auto place = [](const std::string& model) {
    const auto found = std::ranges::find(kModels, model);
    return found == kModels.end() ? -1 : found - kModels.begin();
  };
  return {{world.model, chosen, chosen == world.model ? 100. : 0.,
           place(chosen) > place(world.model) ? 100. : 0., world.options.sigma_px,
           static_cast<double>(world.options.num_views)}};
}

}  // namespace

Study model_confusion_study() {
  return {.name = "model_confusion",
          .summary = "the model that `auto` chooses against the one that made the data",
          .columns = {"truth", "chosen", "right", "larger", "sigma_px", "views"},
          .tasks =
              [](const StudyOptions&) {
                return std::vector<Task>{
                    {"as drawn", [](std::uint64_t seed) { return measure(seed, false); }, 0, true},
                    {"last step shrunk", [](std::uint64_t seed) { return measure(seed, true); }, 0,
                     true}};
              },
          .tables = {{{"task"},
                      {rows_in("sets"), mean_of("right, %", "right", 1),
                       mean_of("larger, %", "larger", 1)}},
                     {{"task", "truth"}, {rows_in("sets"), counts_of("chosen", "chosen")}}}};
}

}  // namespace tagcal
