// Counts tags reported in pictures of 640x480 without tags: noise, smoothed noise, rows of
// letter-like strokes, checkerboards, and clutter of dark frames with random bits, in turn. Tasks:
// a Kalibr board, and plain boards of every family.

#include <algorithm>

#include "false_tag_pictures.hpp"
#include "studies/studies.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"

namespace tagcal {
using namespace study;
namespace {

Task task_of(const std::string& name, const Board& board) {
  return {name, [board](std::uint64_t seed) -> std::vector<Values> {
            DetectOptions options;
            options.threads = 1;
            const View view = detect(picture_without_tags(seed), {{board, Pose()}}, options).view;
            const auto tags = static_cast<double>(view.observations.size() / 4);
            return {{tags, tags > 0 ? 1. : 0.}};
          }};
}

std::vector<Task> tasks(const StudyOptions&) {
  std::vector<Task> tasks = {
      task_of("tag36h11 border 2", make_board(AprilGrid{6, 6, 0.088, 0.3, 0}))};
  for (const std::string& family : tag_family_names()) {
    const int ids = std::min(36, static_cast<int>(tag_family(family, 1).codes.size()));
    tasks.push_back(task_of(family + " border 1",
                            make_board(AprilGrid{6, ids / 6, 0.04, 1.2, 0, family, 1, false})));
  }
  return tasks;
}

}  // namespace

Study false_tags_study() {
  return {.name = "false_tags",
          .summary = "tags that are found in pictures without tags",
          .count = 1000,
          .columns = {"tags", "with_tag"},
          .tasks = tasks,
          .tables = {
              {{"task"},
               {rows_in("pictures"), sum_of("with a tag", "with_tag"), sum_of("tags", "tags")}}}};
}

}  // namespace tagcal
