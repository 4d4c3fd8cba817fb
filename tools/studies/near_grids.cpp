// Measures the tags of AprilGrids that reach over 100 to 175 degrees of a fisheye's view
// (docs/trust/corners.md), beside OpenCV's aruco: plain ones and Kalibr's, through three kinds of
// lenses that see 150, 180 and 195 degrees. Counted are the corners of tags that lie in the picture
// as a whole with sides of 12 px and more; a corner is wrong if it is off by more than 0.5 px.

#include <fmt/format.h>

#include <cmath>

#include "checker_pictures.hpp"
#include "rendered_near_grid.hpp"
#include "studies/studies.hpp"
#include "study/peers/tag_peers.hpp"
#include "study/processor_time.hpp"

namespace tagcal {
using namespace study;
namespace {

constexpr double kFarPx = 0.5;
constexpr double kFieldsDeg[] = {150, 180, 195};

FoundCorners by_aruco(const CheckerView& view, int border_bits) {
  FoundCorners found;
  Lap lap;
  const std::vector<PeerTag> tags = aruco_tags(view.image, border_bits);
  found.ms = 1e3 * lap();
  for (const PeerTag& tag : tags)
    for (int i = 0; i < 4; ++i)
      found.view.observations.push_back(
          {{tag.id, i}, tag.corners[static_cast<std::size_t>(i)], {}});
  return found;
}

// Without the right corners of tags that are not counted.
FoundCorners counted(FoundCorners found, const NearGridView& view) {
  std::erase_if(found.view.observations, [&](const Observation& seen) {
    const auto truth = view.others.find(seen.id);
    return truth != view.others.end() && (truth->second - seen.pixel).norm() <= kFarPx;
  });
  return found;
}

std::vector<Values> measure(NearGridSpec spec, std::uint64_t trial) {
  const char* const models[] = {"fisheye4", "ds", "eucm"};
  Random random(51, trial);
  spec.model = models[trial % 3];
  spec.span_deg = random.uniform(100, 175);
  spec.noise_levels = random.uniform(1, 3);
  const NearGridView view = near_grid_view(spec, random);
  const double none = std::nan("");
  const auto row = [&](const char* method, const FoundCorners& found) {
    return checker_row(method, view.corners, counted(found, view), none, kFarPx);
  };
  return {row("fit", corners_by_fit(view.image, view.board, nullptr)),
          row("aruco", by_aruco(view, spec.border_bits))};
}

std::vector<Task> near_grids_tasks(const StudyOptions&) {
  std::vector<Task> tasks;
  for (const double field : kFieldsDeg)
    for (const int border : {1, 2}) {
      NearGridSpec spec;
      spec.field_deg = field;
      spec.border_bits = border;
      tasks.push_back({fmt::format("{:.0f} degrees, {}", field, border == 1 ? "plain" : "Kalibr"),
                       [spec](std::uint64_t trial) { return measure(spec, trial); }});
    }
  return tasks;
}

}  // namespace

Study near_grids_study() {
  return {.name = "near_grids",
          .summary = "tags of AprilGrids close to a fisheye camera, beside OpenCV's aruco",
          .count = 40,
          .columns = checker_columns(),
          .tasks = near_grids_tasks,
          .tables = {{{"task", "method"}, checker_figures("boards", false)}}};
}

}  // namespace tagcal
