// The map of calibrations from partly wrong views.

#include <algorithm>
#include <cmath>
#include <set>

#include "study/atlas/map_calibration.hpp"
#include "study/atlas/map_pose.hpp"

namespace tagcal::study {
namespace {

enum class MixedViews { anywhere, swapped, turned, other_ids };

constexpr int kTags = 9;

// A board of tags whose corners have the numbers of the points of `points`.
Board tag_board() { return make_board(AprilGrid{3, 3, 0.16, 0.3, 0}); }

Board points_of(const Board& tags) {
  Points board;
  const Eigen::Vector3d middle(0.284, 0.284, 0);
  for (const TargetPoint& p : target_points(tags))
    board.points.push_back({{4 * p.id.tag_id + p.id.corner, 0}, p.position - middle});
  return {std::move(board), {}};
}

// The numbers of a view's corners after a mix-up of some tags; corners that keep theirs are
// correct.
std::vector<int> mixed_names(MixedViews kind, const std::vector<std::size_t>& tags) {
  std::vector<int> names(4 * kTags);
  for (int i = 0; i < 4 * kTags; ++i) names[static_cast<std::size_t>(i)] = i;
  for (std::size_t t = 0; t < tags.size(); ++t) {
    const std::size_t tag = 4 * tags[t];
    if (kind == MixedViews::swapped) std::swap(names[tag], names[tag + 1]);
    if (kind == MixedViews::turned) std::rotate(&names[tag], &names[tag] + 1, &names[tag] + 4);
    if (kind == MixedViews::other_ids)
      for (std::size_t c = 0; c < 4; ++c)
        names[tag + c] = static_cast<int>(4 * tags[(t + 1) % tags.size()] + c);
  }
  return names;
}

// Spoils one view of both data sets: `asked` has all corners, `good` those that stay correct.
void spoil(View& asked, View& good, MixedViews kind, double share, Random& random) {
  const auto tags = static_cast<std::size_t>(std::lround(share * kTags));
  const std::vector<int> names = mixed_names(kind, some_of(kTags, tags, random));
  const std::vector<std::size_t> corners = some_of(
      asked.observations.size(),
      static_cast<std::size_t>(std::lround(share * static_cast<double>(asked.observations.size()))),
      random);
  const std::set<std::size_t> moved(corners.begin(), corners.end());
  View right{good.image, {}};
  for (std::size_t i = 0; i < asked.observations.size(); ++i) {
    Observation& o = asked.observations[i];
    const int number = 4 * o.id.tag_id + o.id.corner;
    bool stays = true;
    if (kind == MixedViews::anywhere) {
      stays = !moved.contains(i);
      if (!stays) o.pixel = {random.uniform(0, 1280), random.uniform(0, 800)};
    } else {
      const int name = names[static_cast<std::size_t>(number)];
      stays = name == number;
      o.id = {name / 4, name % 4};
    }
    if (stays) right.observations.push_back(good.observations[i]);
  }
  good = right;
}

CalibrationQuestion wrong_in_part(MixedViews kind, double share, Random& random) {
  constexpr int kViews = 8;
  CalibrationTask task = pinhole_task();
  const Board tags = tag_board();
  task.dataset.boards = {{points_of(tags), Pose()}};
  for (int i = 0; i < kViews; ++i) add_view(task, draw_view(random.uniform(0, 45), random), random);
  CalibrationQuestion question = ask_all(std::move(task));
  question.dataset.boards = {{tags, Pose()}};
  for (View& view : question.dataset.views)
    for (Observation& o : view.observations) o.id = {o.id.tag_id / 4, o.id.tag_id % 4};
  for (std::size_t v = 0; v < kViews / 2; ++v)
    spoil(question.dataset.views[v], question.good.dataset.views[v], kind, share, random);
  return question;
}

}  // namespace

StabilityMap wrong_views_map() {
  StabilityMap map;
  map.name = "calibrate-wrong-views";
  map.title = "Calibration: eight views of nine tags, half of which are wrong in part";
  map.axes = {{"share wrong", "", {0, 0.03, 0.1, 0.2, 0.3, 0.5}, {}},
              {"kind",
               "",
               {0, 1, 2, 3},  // MixedViews
               {"corners anywhere", "corners swapped", "tags turned", "ids exchanged"}}};
  map.what =
      "A few corners that are not what their name says pull a least-squares calibration away";
  map.why =
      "One wrong point has no bound on what it does to a least-squares fit (Fischler & Bolles, "
      "CACM "
      "1981), and its standard deviations do not know of it";
  map.answer =
      "tagcal looks for a consensus in each view before it solves, leaves out what is beyond 5 "
      "sigma, and lists it";
  map.exempt = {"a board whose every tag is wrong in every view: nothing disagrees with it"};
  ask_calibration(map,
                  {our_calibration(), our_calibration_by_name(), opencv_calibration(),
                   opencv_calibration_of("pinhole")},
                  [](std::span<const double> at, Random& random) {
                    return wrong_in_part(static_cast<MixedViews>(static_cast<int>(at[1])), at[0],
                                         random);
                  });
  return map;
}

}  // namespace tagcal::study
