// Maps of poses from partly wrong data.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "study/atlas/map_pose.hpp"
#include "study/peers/pose_peers.hpp"
#include "study/tasks/pose_tasks.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kLeastRightTags = 3;  // two may agree by chance

PoseTask board_task(int n, Random& random) {
  PoseTask task = draw_task(tag_grid_points(n), {}, random);
  task.groups = tag_grid_groups(n);
  return task;
}

Vector2d anywhere(Random& random) { return {random.uniform(0, 1280), random.uniform(0, 800)}; }

std::vector<std::size_t> other_corners(std::size_t n, const std::vector<std::size_t>& wrong) {
  std::vector<std::size_t> right;
  for (std::size_t i = 0; i < n; ++i)
    if (!std::binary_search(wrong.begin(), wrong.end(), i)) right.push_back(i);
  return right;
}

PoseQuestion wrong_corners(double share, Random& random) {
  PoseQuestion question{board_task(6, random)};
  auto& corners = question.task.correspondences;
  const std::size_t n = corners.size();
  const auto count = static_cast<std::size_t>(std::lround(share * static_cast<double>(n)));
  const auto wrong = some_of(n, count, random);
  for (const std::size_t i : wrong) corners[i].pixel = anywhere(random);
  question.right = other_corners(n, wrong);
  question.knowable = beyond_chance(n, question.right.size(), question.task.sigma_px);
  return question;
}

// Tags that are displaced as a whole, like tags with a wrong id.
PoseQuestion wrong_tags(double share, Random& random) {
  PoseQuestion question{board_task(6, random)};
  auto& corners = question.task.correspondences;
  const std::size_t tags = corners.size() / 4;
  const auto count = static_cast<std::size_t>(std::lround(share * static_cast<double>(tags)));
  std::vector<std::size_t> wrong;
  for (const std::size_t tag : some_of(tags, count, random)) {
    const Vector2d shift = anywhere(random) - corners[4 * tag].pixel;
    for (std::size_t k = 0; k < 4; ++k) {
      corners[4 * tag + k].pixel += shift;
      wrong.push_back(4 * tag + k);
    }
  }
  question.right = other_corners(corners.size(), wrong);
  question.knowable = question.right.size() >= 4 * kLeastRightTags;
  return question;
}

enum Mixup { corners_swapped, turned, mirrored, two_ids, third_of_ids, all_turned, all_mirrored };

// The index of the true corner at each corner of a tag.
std::array<std::size_t, 4> order_of(Mixup mixup) {
  if (mixup == corners_swapped) return {1, 0, 2, 3};
  if (mixup == turned || mixup == all_turned) return {1, 2, 3, 0};
  return {1, 0, 3, 2};
}

PoseQuestion mixed_up(Mixup mixup, int tags_across, Random& random) {
  PoseQuestion question{board_task(tags_across, random)};
  auto& corners = question.task.correspondences;
  const auto seen = corners;
  const std::size_t tags = corners.size() / 4;
  std::vector<std::size_t> wrong;
  if (mixup == two_ids || mixup == third_of_ids) {
    const std::size_t count = mixup == two_ids ? 2 : std::max<std::size_t>(2, tags / 3);
    const auto mixed = some_of(tags, count, random);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t corner = 4 * mixed[i] + k;
        corners[corner].pixel = seen[4 * mixed[(i + 1) % count] + k].pixel;
        wrong.push_back(corner);
      }
  } else {
    const bool all = mixup == all_turned || mixup == all_mirrored;
    for (const std::size_t tag : some_of(tags, all ? tags : 1, random))
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t from = order_of(mixup)[k];
        corners[4 * tag + k].pixel = seen[4 * tag + from].pixel;
        if (from != k) wrong.push_back(4 * tag + k);
      }
  }
  std::sort(wrong.begin(), wrong.end());
  question.right = other_corners(corners.size(), wrong);
  question.knowable = question.right.size() >= 4 * kLeastRightTags;
  return question;
}

enum Defect { nan_pixel, infinite_pixel, nan_point, one_place, duplicate, far_pixel };

PoseQuestion spoiled(Defect defect, std::size_t n, Random& random) {
  PoseQuestion question =
      all_right(draw_task(n == 4 ? square_points(0.3) : tag_grid_points(3), {}, random));
  auto& corners = question.task.correspondences;
  const std::size_t i = random.index(n);
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  question.right = other_corners(n, {i});
  if (defect == nan_pixel) corners[i].pixel.x() = kNone;
  if (defect == infinite_pixel) corners[i].pixel.y() = std::numeric_limits<double>::infinity();
  if (defect == nan_point) corners[i].point.z() = kNone;
  if (defect == far_pixel) corners[i].pixel.x() = 1e9;
  if (defect == duplicate) corners[i] = corners[(i + 1) % n];
  if (defect == one_place) {
    for (Correspondence& c : corners) c.point = corners.front().point;
    question.right.clear();
  }
  question.knowable = n > 4 && (defect == far_pixel || defect == duplicate);
  return question;
}

}  // namespace

StabilityMap wrong_corners_map() {
  enum Kind { single, whole_tags };
  StabilityMap map;
  map.name = "wrong-corners";
  map.title = "Wrong corners of a board of 144, 0.5 px of noise";
  map.axes = {{"share wrong", "", {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9}, {}},
              {"kind", "", {single, whole_tags}, {"single corners", "whole tags"}}};
  map.what = "Corners that are not what their name says pull a least-squares pose anywhere";
  map.why =
      "One wrong point has no bound on what it does to a least-squares fit, and random samples of "
      "four are all right in (1 - share)^4 of the draws (Fischler & Bolles, CACM 1981)";
  map.answer =
      "tagcal tries tags as well as corners, takes what agrees better than chance would have it, "
      "and says `no_consensus` where nothing does";
  map.exempt = {"the wrong id of a lone tag: nothing disagrees with it"};
  map.peer_trials = 100;
  ask_pose(map,
           {our_pose(), our_pose_of_unknown_noise(), peer(opencv_ransac("solvePnPRansac")),
            peer(opencv_ransac("USAC MAGSAC")), aside(opencv_ransac("solvePnPRansac AP3P")),
            aside(opencv_pose("ITERATIVE"))},
           [](std::span<const double> at, Random& random) {
             return static_cast<int>(at[1]) == single ? wrong_corners(at[0], random)
                                                      : wrong_tags(at[0], random);
           });
  return map;
}

StabilityMap swapped_map() {
  StabilityMap map;
  map.name = "swapped";
  map.title = "Swapped corners and wrong ids, 0.5 px of noise";
  map.axes = {{"mix-up",
               "",
               {corners_swapped, turned, mirrored, two_ids, third_of_ids, all_turned, all_mirrored},
               {"two corners", "a tag turned", "a tag mirrored", "two ids", "a third of the ids",
                "all turned", "all mirrored"}},
              {"board", "", {2, 3, 6}, {"2 x 2 tags", "3 x 3 tags", "6 x 6 tags"}}};
  map.what =
      "Corners in another order and tags with each other's ids are wrong in a way that agrees with "
      "itself";
  map.why =
      "The corners of a square in another order are those of the square in another attitude, and "
      "ids that are shifted are the board in another place (Olson, ICRA 2011)";
  map.answer =
      "tagcal leaves out the tags that do not go with the others and answers from those, or says "
      "`no_consensus`";
  map.exempt = {"all ids of a board shifted by a row: it is the board in another place",
                "a lone tag with another id, or turned by a quarter: nothing disagrees with it"};
  ask_pose(map,
           {our_pose(), our_pose_of_unknown_noise(), peer(opencv_ransac("solvePnPRansac")),
            peer(opencv_pose("ITERATIVE")), aside(opencv_ransac("USAC MAGSAC")),
            aside(opencv_pose("IPPE"))},
           [](std::span<const double> at, Random& random) {
             return mixed_up(static_cast<Mixup>(at[0]), static_cast<int>(at[1]), random);
           });
  return map;
}

StabilityMap bad_data_map() {
  StabilityMap map;
  map.name = "bad-data";
  map.title = "Numbers that are none, points that are one";
  map.axes = {{"defect",
               "",
               {nan_pixel, infinite_pixel, nan_point, one_place, duplicate, far_pixel},
               {"NaN in a pixel", "infinite pixel", "NaN in a point", "all at one place",
                "a point twice", "a pixel at 1e9"}},
              {"points", "", {4, 36}, {}}};
  map.what = "A number that is none runs through a solver to its end";
  map.why =
      "Comparisons with NaN are false, so that convergence tests pass, and a lost rank leaves a "
      "pose that any residual fits (OpenCV 4.6: five of seven methods of solvePnP answer `true`)";
  map.answer =
      "tagcal looks at its input first: `degenerate` with the reason; one wild pixel among many is "
      "left out by name";
  ask_pose(map,
           {our_pose(), peer(opencv_pose("ITERATIVE")), peer(opencv_pose("EPNP")),
            peer(opencv_pose("SQPNP")), aside(opencv_pose("IPPE"))},
           [](std::span<const double> at, Random& random) {
             return spoiled(static_cast<Defect>(at[0]), static_cast<std::size_t>(at[1]), random);
           });
  return map;
}

}  // namespace tagcal::study
