#include "tagcal/estimate/handeye/handeye_start.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tagcal/estimate/policy/handeye_policy.hpp"
#include "tagcal/estimate/rig/motion_start.hpp"
#include "tagcal/random.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

HandeyeStart start_at(const HandeyePlaces& places, std::span<const HandeyePair> views,
                      CameraMount mount, const HandeyeScale& scale) {
  HandeyeStart start{places, {}, 0};
  for (const HandeyePair& v : views) {
    start.disagreements_m.push_back(
        disagreement_m(places, mount, scale, v.camera_from_board, v.base_from_hand));
    start.rms_m += start.disagreements_m.back() * start.disagreements_m.back();
  }
  start.rms_m = std::sqrt(start.rms_m / static_cast<double>(views.size()));
  return start;
}

// Of a hand that does not turn: t_C = R_X' (t_M + R_M t_Y - t_X), where the last two terms are the
// same for all views, and so are the rotations. The camera is put at the mount's origin.
std::optional<HandeyePlaces> places_by_translations(std::span<const HandeyePair> views,
                                                    CameraMount mount) {
  Vector3d mean_seen = Vector3d::Zero(), mean_hand = Vector3d::Zero();
  for (const HandeyePair& v : views) {
    mean_seen += v.camera_from_board.translation() / static_cast<double>(views.size());
    mean_hand += mount_from_holder(mount, v.base_from_hand).translation() /
                 static_cast<double>(views.size());
  }
  Matrix3d sum = Matrix3d::Zero();
  for (const HandeyePair& v : views)
    sum += (mount_from_holder(mount, v.base_from_hand).translation() - mean_hand) *
           (v.camera_from_board.translation() - mean_seen).transpose();
  const Vector3d size = Eigen::JacobiSVD<Matrix3d>(sum).singularValues();
  constexpr double kRounding = 1e-12;  // numeric: squares of metres
  if (!(size[1] > kRounding)) return std::nullopt;
  const Pose mount_from_camera(nearest_rotation(sum), Vector3d::Zero());
  Matrix3d of_board = Matrix3d::Zero();
  Vector3d board = Vector3d::Zero();
  for (const HandeyePair& v : views) {
    const Pose holder_from_mount = mount_from_holder(mount, v.base_from_hand).inverse();
    const Pose holder_from_board = holder_from_mount * mount_from_camera * v.camera_from_board;
    of_board += holder_from_board.rotation_matrix();
    board += holder_from_board.translation() / static_cast<double>(views.size());
  }
  return HandeyePlaces{mount_from_camera, {nearest_rotation(of_board), board}};
}

double median_of(const HandeyeStart& start) { return median(start.disagreements_m); }

std::optional<HandeyeStart> start_of_some(std::span<const HandeyePair> views,
                                          std::span<const std::size_t> chosen, CameraMount mount,
                                          const HandeyeScale& scale) {
  std::vector<HandeyePair> some;
  for (const std::size_t i : chosen) some.push_back(views[i]);
  const auto found = closed_form_places(some, mount, scale);
  if (!found) return std::nullopt;
  return start_at(found->places, views, mount, scale);
}

std::vector<std::size_t> agreeing(const HandeyeStart& start, const HandeyeScale& scale) {
  constexpr double kExact = 1e-9;  // numeric: rounding
  const double most = std::max(policy::kRobotOutlier * median_of(start), kExact * scale.distance_m);
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < start.disagreements_m.size(); ++i)
    if (start.disagreements_m[i] <= most) chosen.push_back(i);
  return chosen;
}

// All views agree: sampling would only take time.
bool is_plain(const HandeyeStart& start, const HandeyeScale& scale) {
  constexpr double kGood = 0.01;  // numeric: of the distance, wrong poses leave more
  return median_of(start) < kGood * scale.distance_m &&
         agreeing(start, scale).size() == start.disagreements_m.size();
}

// The better of a start and what triples give.
HandeyeStart with_triples(HandeyeStart best, std::span<const HandeyePair> views, CameraMount mount,
                          const HandeyeScale& scale) {
  // With half of the views wrong, all of 60 triples have a wrong one with a probability of 3e-4.
  constexpr int kTriples = 60;
  Random random(0);
  for (int k = 0; k < kTriples; ++k) {
    std::array<std::size_t, 3> triple;
    for (std::size_t& i : triple) i = random.index(views.size());
    std::ranges::sort(triple);
    if (std::ranges::adjacent_find(triple) != triple.end()) continue;
    auto found = start_of_some(views, triple, mount, scale);
    if (found && median_of(*found) < median_of(best)) best = *std::move(found);
  }
  return best;
}

}  // namespace

std::optional<HandeyeStart> closed_form_places(std::span<const HandeyePair> views,
                                               CameraMount mount, const HandeyeScale& scale) {
  if (views.size() < 3) return std::nullopt;
  std::vector<MotionPair> motions;
  for (const HandeyePair& v : views)
    motions.push_back({v.camera_from_board, mount_from_holder(mount, v.base_from_hand)});
  std::optional<HandeyeStart> best;
  for (const MotionStart& start : motion_starts(motions)) {
    HandeyeStart turned =
        start_at({start.camera_from_rig.inverse(), start.world_from_board}, views, mount, scale);
    if (!best || turned.rms_m < best->rms_m) best = std::move(turned);
  }
  if (const auto places = places_by_translations(views, mount)) {
    HandeyeStart unturned = start_at(*places, views, mount, scale);
    if (!best || unturned.rms_m < best->rms_m) best = std::move(unturned);
  }
  return best;
}

std::optional<RobustHandeyeStart> robust_places(std::span<const HandeyePair> views,
                                                CameraMount mount, const HandeyeScale& scale) {
  auto best = closed_form_places(views, mount, scale);
  if (!best) return std::nullopt;
  RobustHandeyeStart result{best->places, std::vector<std::uint8_t>(views.size(), 1)};
  if (std::ssize(views) < policy::kFewestHandeyeMedian || is_plain(*best, scale)) return result;
  *best = with_triples(*std::move(best), views, mount, scale);
  constexpr int kRounds = 4;  // a limit of work
  for (int i = 0; i < kRounds; ++i) {
    const auto chosen = agreeing(*best, scale);
    auto next = start_of_some(views, chosen, mount, scale);
    if (!next || chosen == agreeing(*next, scale)) {
      if (next) best = std::move(next);
      break;
    }
    best = std::move(next);
  }
  result.places = best->places;
  std::ranges::fill(result.takes_part, 0);
  for (const std::size_t i : agreeing(*best, scale)) result.takes_part[i] = 1;
  return result;
}

}  // namespace tagcal::internal
