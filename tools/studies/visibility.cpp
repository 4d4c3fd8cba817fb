// Holds the renderer and the exact corners to rays, in random scenes of 2 to 12 sheets that cut
// each other, hide each other in rings, share edges or lie in one plane, through perspective,
// fisheye and parallel lenses: every pixel at least 1 px from a visible border or intersection of
// sheets.

#include "random_sheets.hpp"
#include "studies/studies.hpp"
#include "tagcal/detect/families.hpp"

namespace tagcal {
using namespace study;

Study visibility_study() {
  const auto measure = [](std::uint64_t scene) -> std::vector<Values> {
    static const TagFamilies families = {{"tag36h11", tag_family("tag36h11", 1)}};
    sheet_rays::Counts n;
    sheet_rays::compare(1, scene, families, n);
    Values values;
    for (const long count : {n.cut_scenes, n.pixels, n.wrong_pixels, n.points, n.wrong_points})
      values.emplace_back(static_cast<double>(count));
    return {values};
  };
  return {.name = "visibility",
          .summary = "the renderer's pixels and corners against rays, in scenes of sheets",
          .count = 10000,
          .first = 0,
          .columns = {"cut", "pixels", "wrong_pixels", "points", "wrong_points"},
          .tasks =
              [=](const StudyOptions&) {
                return std::vector<Task>{{"sheets", measure}};
              },
          .tables = {{{"task"},
                      {rows_in("scenes"), sum_of("that cut each other", "cut"),
                       sum_of("pixels", "pixels"), sum_of("wrong", "wrong_pixels"),
                       sum_of("points", "points"), sum_of("wrong", "wrong_points")}}}};
}

}  // namespace tagcal
