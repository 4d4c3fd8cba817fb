#include "tagcal/estimate/handeye/handeye_start.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "tagcal/estimate/policy/handeye_policy.hpp"
#include "tagcal/estimate/rig/motion_start.hpp"
#include "tagcal/random.hpp"

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

std::optional<HandeyeStart> start_of_some(std::span<const HandeyePair> views,
                                          std::span<const std::size_t> chosen, CameraMount mount,
                                          const HandeyeScale& scale) {
  std::vector<HandeyePair> some;
  for (const std::size_t i : chosen) some.push_back(views[i]);
  const auto found = closed_form_places(some, mount, scale);
  if (!found) return std::nullopt;
  return start_at(found->places, views, mount, scale);
}

// Places, and the views that agree best with them: half of all, and as many as the places have
// poses (2). Those of the least squares withstand most wrong views (least trimmed squares;
// Rousseeuw & Van Driessen, Data Min. Knowl. Discov. 12, 29 (2006)).
struct AgreeingHalf {
  HandeyePlaces places;
  std::vector<std::size_t> views;
  double squares = 0;  // of their disagreements
};

AgreeingHalf half_of(const HandeyeStart& start) {
  const std::vector<double>& errors = start.disagreements_m;
  AgreeingHalf half{start.places, std::vector<std::size_t>(errors.size())};
  std::iota(half.views.begin(), half.views.end(), std::size_t{0});
  std::ranges::stable_sort(half.views, {}, [&](std::size_t i) { return errors[i]; });
  half.views.resize((errors.size() + 3) / 2);
  std::ranges::sort(half.views);
  for (const std::size_t i : half.views) half.squares += errors[i] * errors[i];
  return half;
}

// The half of the views that agrees best with the places that a half determines: never worse than
// this half itself ("concentration step").
std::optional<AgreeingHalf> concentrated(const AgreeingHalf& half,
                                         std::span<const HandeyePair> views, CameraMount mount,
                                         const HandeyeScale& scale) {
  const auto start = start_of_some(views, half.views, mount, scale);
  return start ? std::optional(half_of(*start)) : std::nullopt;
}

// The best half from all views and from triples of them.
AgreeingHalf best_half(const HandeyeStart& of_all, std::span<const HandeyePair> views,
                       CameraMount mount, const HandeyeScale& scale) {
  AgreeingHalf best = half_of(of_all);
  // With half of the views wrong, all of 60 triples have a wrong one with a probability of 3e-4.
  constexpr int kTriples = 60;
  Random random(0);
  for (int k = 0; k < kTriples; ++k) {
    std::array<std::size_t, 3> triple;
    for (std::size_t& i : triple) i = random.index(views.size());
    std::ranges::sort(triple);
    if (std::ranges::adjacent_find(triple) != triple.end()) continue;
    const auto start = start_of_some(views, triple, mount, scale);
    auto half = start ? concentrated(half_of(*start), views, mount, scale) : std::nullopt;
    if (half && half->squares < best.squares) best = *std::move(half);
  }
  constexpr int kRounds = 4;  // a limit of work
  for (int i = 0; i < kRounds; ++i) {
    auto next = concentrated(best, views, mount, scale);
    if (!next || !(next->squares < best.squares)) break;
    best = *std::move(next);
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
  const auto of_all = closed_form_places(views, mount, scale);
  if (!of_all) return std::nullopt;
  RobustHandeyeStart result{of_all->places, std::vector<std::uint8_t>(views.size(), 1)};
  if (std::ssize(views) < policy::kFewestConsensus) return result;
  const AgreeingHalf half = best_half(*of_all, views, mount, scale);
  result.places = half.places;
  std::ranges::fill(result.takes_part, 0);
  for (const std::size_t i : half.views) result.takes_part[i] = 1;
  return result;
}

}  // namespace tagcal::internal
