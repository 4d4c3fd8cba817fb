#include "tagcal/estimate/frame_choice.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "tagcal/estimate/advice.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/policy/frame_policy.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/internal/spread_indices.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal {
using namespace internal;
namespace {

constexpr std::size_t kFewestCorners = 4;  // numeric: of a pose

// The median distance of the corners that both views show; no value for fewer than four.
std::optional<double> distance_px(const View& a, const View& b) {
  std::map<CornerId, Eigen::Vector2d> pixels;
  for (const Observation& seen : a.observations) pixels[seen.id] = seen.pixel;
  std::vector<double> distances;
  for (const Observation& seen : b.observations)
    if (const auto found = pixels.find(seen.id); found != pixels.end())
      distances.push_back((seen.pixel - found->second).norm());
  if (distances.size() < kFewestCorners) return std::nullopt;
  return median(std::move(distances));
}

class FrameChooser {
 public:
  FrameChooser(const Dataset& dataset, std::span<const double> times_s)
      : dataset_(dataset), times_s_(times_s) {
    assert(times_s.size() == dataset.views.size());
    result_.fates.assign(times_s.size(), FrameFate::nothing);
    result_.speeds_px.assign(times_s.size(), 0);
  }

  FrameSelection choose(const CalibrateOptions& options, double goal_px) {
    leave_out_empty();
    if (those(FrameFate::nothing).size() > policy::kFewFrames) leave_out_fast();
    const std::vector<std::size_t> candidates = those(FrameFate::nothing);
    if (candidates.size() <= policy::kFewFrames) {
      use(candidates);
    } else if (const auto lens = seed(candidates, options)) {
      choose_by_gain(candidates, *lens, goal_px);
    } else {
      use(spread(candidates, policy::kFramesWithoutLens));
    }
    result_.used = those(FrameFate::used);
    return std::move(result_);
  }

 private:
  std::vector<std::size_t> those(FrameFate fate) const {
    std::vector<std::size_t> views;
    for (std::size_t i = 0; i < result_.fates.size(); ++i)
      if (result_.fates[i] == fate) views.push_back(i);
    return views;
  }

  static std::vector<std::size_t> spread(const std::vector<std::size_t>& views, std::size_t count) {
    std::vector<std::size_t> some;
    for (const std::size_t i : spread_indices(views.size(), count)) some.push_back(views[i]);
    return some;
  }

  void use(const std::vector<std::size_t>& views) {
    for (const std::size_t view : views) result_.fates[view] = FrameFate::used;
  }

  void leave_out_empty() {
    for (std::size_t i = 0; i < dataset_.views.size(); ++i)
      if (dataset_.views[i].observations.size() < kFewestCorners)
        result_.fates[i] = FrameFate::no_board;
  }

  // From the neighbour before to the one behind, so that a turning point is slow; at an end, and
  // where the board was lost, from one neighbour.
  double speed_of(const std::vector<std::size_t>& views, std::size_t i) const {
    const std::size_t before = views[i > 0 ? i - 1 : i];
    const std::size_t behind = views[std::min(i + 1, views.size() - 1)];
    for (const auto& [a, b] : {std::pair(before, behind), {before, views[i]}, {views[i], behind}}) {
      const auto distance = distance_px(dataset_.views[a], dataset_.views[b]);
      if (distance && times_s_[b] > times_s_[a]) return *distance / (times_s_[b] - times_s_[a]);
    }
    return 0;
  }

  void leave_out_fast() {
    const std::vector<std::size_t> views = those(FrameFate::nothing);
    std::vector<double> speeds;
    for (std::size_t i = 0; i < views.size(); ++i) speeds.push_back(speed_of(views, i));
    const double diagonal = std::hypot(dataset_.image_size.width, dataset_.image_size.height);
    const double limit =
        std::max(policy::kFastShare * diagonal, speeds.empty() ? 0 : median(speeds));
    for (std::size_t i = 0; i < views.size(); ++i) {
      result_.speeds_px[views[i]] = speeds[i];
      if (speeds[i] > limit) result_.fates[views[i]] = FrameFate::fast;
    }
  }

  // A calibration of a few frames that can tell what others would add.
  std::optional<Calibration> seed(const std::vector<std::size_t>& candidates,
                                  const CalibrateOptions& options) const {
    Dataset few{dataset_.image_size, dataset_.boards, {}, {}};
    for (const std::size_t view : spread(candidates, policy::kSeedFrames))
      few.views.push_back(dataset_.views[view]);
    Calibration lens = calibrate(few, options);
    if (!is_answer(lens.status) || !lens.camera || lens.covariance.size() == 0) return std::nullopt;
    return lens;
  }

  // Each candidate with its pose, in place of the views of the first calibration.
  void set_poses(const std::vector<std::size_t>& candidates, Calibration& lens) {
    const ViewPoses poses = poses_of_views(dataset_, candidates, *lens.camera, lens.model_error_px);
    for (const std::size_t view : candidates) result_.fates[view] = FrameFate::no_pose;
    for (const CalibratedView& posed : poses.views) result_.fates[posed.view] = FrameFate::nothing;
    lens.views = poses.views;
    lens.outliers = poses.outliers;
  }

  void choose_by_gain(const std::vector<std::size_t>& candidates, Calibration lens,
                      double goal_px) {
    set_poses(candidates, lens);
    const ViewSelection selection =
        select_views(dataset_, lens, static_cast<int>(candidates.size()),
                     {.goal_px = goal_px, .least_gain = policy::kLeastGain});
    for (const SelectedView& view : selection.views) result_.fates[view.view] = FrameFate::used;
    if (!selection.views.empty()) result_.projection_px = selection.views.back().projection_px;
    result_.all_px = selection.all_px;
  }

  const Dataset& dataset_;
  std::span<const double> times_s_;
  FrameSelection result_;
};

}  // namespace

FrameSelection choose_frames(const Dataset& dataset, std::span<const double> times_s,
                             const CalibrateOptions& options, double goal_px) {
  return FrameChooser(dataset, times_s).choose(options, goal_px);
}

}  // namespace tagcal
