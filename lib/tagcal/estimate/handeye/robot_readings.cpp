#include "tagcal/estimate/handeye/robot_readings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tagcal/estimate/policy/handeye_policy.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// R_x(a) R_y(b) R_z(c).
Quaterniond about_xyz(const Vector3d& angles) {
  return (rotation_about_x(angles[0]) * rotation_about_y(angles[1]) * rotation_about_z(angles[2]))
      .rotation();
}

// Angles of R_z(c) R_y(b) R_x(a), those of roll, pitch, yaw.
Vector3d angles_of(const Quaterniond& q) {
  const RollPitchYaw angles = roll_pitch_yaw(q);
  return {angles.roll_rad, angles.pitch_rad, angles.yaw_rad};
}

struct RotationReading {
  const char* change;
  Quaterniond (*read)(const Quaterniond&);
};
const std::array kRotations = {
    RotationReading{"", [](const Quaterniond& q) { return q; }},
    RotationReading{"the quaternions are in the order x y z w",
                    [](const Quaterniond& q) { return Quaterniond(q.z(), q.w(), q.x(), q.y()); }},
    RotationReading{"the quaternions are in the order w x y z",
                    [](const Quaterniond& q) { return Quaterniond(q.x(), q.y(), q.z(), q.w()); }},
    RotationReading{"the rotations are inverse (the translations are not)",
                    [](const Quaterniond& q) { return q.conjugate(); }},
    RotationReading{"the angles turn about x, then the new y, then the new z",
                    [](const Quaterniond& q) { return about_xyz(angles_of(q)); }},
    RotationReading{"the angles turn about the fixed axes x, y, z in this order",
                    [](const Quaterniond& q) {
                      // R_x(a) R_y(b) R_z(c) is the inverse of R_z(-c) R_y(-b) R_x(-a).
                      return about_xyz(angles_of(q.conjugate())).conjugate();
                    }},
    RotationReading{"the angles are radians, not degrees", [](const Quaterniond& q) {
                      return exp_rotation(degrees(1) * log_rotation(q));
                    }}};

struct LengthReading {
  const char* change;
  double factor;
};
constexpr std::array kLengths = {
    LengthReading{"", 1}, LengthReading{"the lengths are millimetres, not metres", 1.0 / 1000},
    LengthReading{"the lengths are metres, not millimetres", 1e3}};

std::string joined(const std::vector<std::string>& changes) {
  std::string all;
  for (const std::string& change : changes)
    if (!change.empty()) all += (all.empty() ? "" : ", and ") + change;
  return all;
}

// The level of the disagreements: outlying views do not count if there are enough views to tell.
double level_of(const HandeyeStart& start) {
  if (std::ssize(start.disagreements_m) < policy::kFewestConsensus) return start.rms_m;
  return median(start.disagreements_m);
}

// Sums of squared disagreements that have this ratio, squared, do not have it by chance.
bool is_no_chance(double better, std::size_t num_views) {
  const double freedoms = 6 * static_cast<double>(num_views) - 12;
  return variance_ratio_score(better * better, freedoms, freedoms) >= policy::kSignificant;
}

class Readings {
 public:
  Readings(std::span<const HandeyePair> views, CameraMount mount, const HandeyeScale& scale)
      : mount_(mount), scale_(scale), views_(views.begin(), views.end()) {
    given_ = level(views_);
  }

  std::optional<BetterReading> best() {
    for (const RotationReading& rotation : kRotations)
      for (const LengthReading& length : kLengths)
        for (const bool inverse : {false, true}) try_reading(rotation, length, inverse);
    for (const int shift : {-2, -1, 1, 2}) try_shift(shift);
    return best_;
  }

 private:
  double level(std::span<const HandeyePair> views) const {
    const auto start = closed_form_places(views, mount_, scale_);
    constexpr double kExact = 1e-9;  // numeric: rounding
    return start ? std::max(level_of(*start), kExact * scale_.distance_m)
                 : std::numeric_limits<double>::infinity();
  }

  // Keeps a reading that is certain rather than one that is not.
  void compare(std::span<const HandeyePair> views, BetterReading reading) {
    const double better = given_ / level(views);
    reading.reading.times_better = better;
    reading.is_certain = better >= policy::kReadingBetter && is_no_chance(better, views.size());
    if (!(better > 1) || (reading.is_shift && !reading.is_certain)) return;
    const auto rank = [](const BetterReading& r) {
      return std::pair(r.is_certain, r.reading.times_better);
    };
    if (!best_ || rank(reading) > rank(*best_)) best_ = std::move(reading);
  }

  void try_reading(const RotationReading& rotation, const LengthReading& length, bool inverse) {
    const std::string change = joined(
        {rotation.change, length.change,
         inverse ? fmt::format("the poses are hand_from_base, not base_from_hand (or the camera "
                               "is {}: --mount {})",
                               mount_ == CameraMount::hand ? "beside the robot" : "on the hand",
                               mount_ == CameraMount::hand ? "base" : "hand")
                 : std::string()});
    if (change.empty()) return;
    const auto read = [rotation, length, inverse](const Pose& pose) {
      const Pose changed(rotation.read(pose.rotation()), length.factor * pose.translation());
      return inverse ? changed.inverse() : changed;
    };
    std::vector<HandeyePair> views = views_;
    for (HandeyePair& v : views) v.base_from_hand = read(v.base_from_hand);
    compare(views, {{change}, read});
  }

  void try_shift(int shift) {
    std::vector<HandeyePair> views;
    for (int i = 0; i < std::ssize(views_); ++i)
      if (i + shift >= 0 && i + shift < std::ssize(views_))
        views.push_back({views_[static_cast<std::size_t>(i)].camera_from_board,
                         views_[static_cast<std::size_t>(i + shift)].base_from_hand});
    if (std::ssize(views) < policy::kFewestConsensus) return;
    const std::string change =
        fmt::format("each picture belongs to the pose of the picture {} {} it", std::abs(shift),
                    shift > 0 ? "after" : "before");
    compare(views, {{change}, nullptr, true});
  }

  CameraMount mount_;
  HandeyeScale scale_;
  std::vector<HandeyePair> views_;
  double given_ = 0;
  std::optional<BetterReading> best_;
};

}  // namespace

bool can_show_reading(std::size_t num_views) {
  return is_no_chance(policy::kReadingBetter, num_views);
}

std::optional<BetterReading> better_reading(std::span<const HandeyePair> views, CameraMount mount,
                                            const HandeyeScale& scale) {
  if (views.size() < 3) return std::nullopt;
  constexpr std::size_t kMost = 24;  // views: a limit of work
  return Readings(views.first(std::min(views.size(), kMost)), mount, scale).best();
}

}  // namespace tagcal::internal
