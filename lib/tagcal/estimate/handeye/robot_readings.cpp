#include "tagcal/estimate/handeye/robot_readings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
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

using Numbers = RotationNumbers;

// R_x(a) R_y(b) R_z(c).
Quaterniond about_xyz(const Vector3d& angles) {
  return (rotation_about_x(angles[0]) * rotation_about_y(angles[1]) * rotation_about_z(angles[2]))
      .rotation();
}

// R_z(c) R_y(b) R_x(a), of roll, pitch, yaw.
Quaterniond about_zyx(const Vector3d& angles) { return about_xyz(-angles).conjugate(); }

// Angles of R_z(c) R_y(b) R_x(a), those of roll, pitch, yaw.
Vector3d angles_of(const Quaterniond& q) {
  const RollPitchYaw angles = roll_pitch_yaw(q);
  return {angles.roll_rad, angles.pitch_rad, angles.yaw_rad};
}

Vector3d first_three(const Numbers& n) { return {n[0], n[1], n[2]}; }

Quaterniond quaternion_of(const Numbers& n) { return {n[0], n[1], n[2], n[3]}; }

// The numbers of a rotation in a form; of quaternions w x y z.
Numbers numbers_of(const Quaterniond& q, RotationForm form) {
  if (form == RotationForm::vector || form == RotationForm::roll_pitch_yaw) {
    const Vector3d v = form == RotationForm::vector ? log_rotation(q) : angles_of(q);
    return {v[0], v[1], v[2], 0};
  }
  return {q.w(), q.x(), q.y(), q.z()};
}

// Another meaning of the numbers of a rotation.
struct RotationReading {
  const char* change;
  Quaterniond (*read)(const Numbers&);
  // The form of the numbers; unknown: they are a quaternion w x y z, which all rotations have.
  RotationForm form = RotationForm::unknown;
  enum Tried { always, known_form, unknown_form } tried = always;
  bool from_degrees = false;
};

using enum RotationForm;
const std::array kRotations = {
    RotationReading{"", quaternion_of},
    RotationReading{"the rotations are inverse (the translations are not)",
                    [](const Numbers& n) { return quaternion_of(n).conjugate(); }},
    RotationReading{"the quaternions are in the order x y z w",
                    [](const Numbers& n) { return Quaterniond(n[3], n[0], n[1], n[2]); }, wxyz},
    RotationReading{"the quaternions are in the order w x y z",
                    [](const Numbers& n) { return Quaterniond(n[1], n[2], n[3], n[0]); }, xyzw},
    RotationReading{"the angles turn about x, then the new y, then the new z",
                    [](const Numbers& n) { return about_xyz(first_three(n)); }, roll_pitch_yaw},
    RotationReading{"the angles are in the order yaw, pitch, roll",
                    [](const Numbers& n) { return about_zyx(first_three(n).reverse()); },
                    roll_pitch_yaw, RotationReading::known_form},
    RotationReading{"roll, pitch and yaw are a rotation vector",
                    [](const Numbers& n) { return exp_rotation(first_three(n)); }, roll_pitch_yaw,
                    RotationReading::known_form},
    RotationReading{"the rotation vectors are roll, pitch and yaw",
                    [](const Numbers& n) { return about_zyx(first_three(n)); }, vector,
                    RotationReading::known_form},
    RotationReading{"the angles turn about the fixed axes x, y, z in this order",
                    [](const Numbers& n) {
                      // R_x(a) R_y(b) R_z(c) is the inverse of R_z(-c) R_y(-b) R_x(-a).
                      return about_xyz(angles_of(quaternion_of(n).conjugate())).conjugate();
                    },
                    unknown, RotationReading::unknown_form},
    RotationReading{"the angles are radians, not degrees",
                    [](const Numbers& n) { return exp_rotation(degrees(1) * first_three(n)); },
                    vector, RotationReading::always, true},
    RotationReading{"the angles are radians, not degrees",
                    [](const Numbers& n) { return about_zyx(degrees(1) * first_three(n)); },
                    roll_pitch_yaw, RotationReading::known_form, true}};

bool allows(const RobotForm& form, const RotationReading& reading) {
  if (form.rotation == unknown) return reading.tried != RotationReading::known_form;
  return reading.tried != RotationReading::unknown_form &&
         (reading.form == unknown || reading.form == form.rotation) &&
         (!reading.from_degrees || form.in_degrees);
}

Quaterniond rotation_of(const HandeyePair& pair, const RotationReading& reading) {
  const bool has_numbers = pair.rotation_numbers && reading.form != unknown;
  return reading.read(has_numbers ? *pair.rotation_numbers
                                  : numbers_of(pair.base_from_hand.rotation(), reading.form));
}

struct LengthUnit {
  const char* name;
  double metres;
};
constexpr std::array kUnits = {LengthUnit{"metres", 1},
                               LengthUnit{"millimetres", 1e-3},  // numeric: exact
                               LengthUnit{"centimetres", 1e-2},  // numeric: exact
                               LengthUnit{"inches", 0.0254}};    // numeric: exact

// Lengths that are of another unit than that of the file.
struct LengthReading {
  std::string change;
  double factor = 1;
};
std::vector<LengthReading> length_readings(const RobotForm& form) {
  std::vector<LengthReading> readings = {{}};
  for (const LengthUnit& of_file : std::span(kUnits).first(2))
    for (const LengthUnit& unit : kUnits)
      if ((form.length_unit_m == 0 || form.length_unit_m == of_file.metres) &&
          unit.metres != of_file.metres)
        readings.push_back({fmt::format("the lengths are {}, not {}", unit.name, of_file.name),
                            unit.metres / of_file.metres});
  return readings;
}

std::string joined(const std::vector<std::string>& changes) {
  return fmt::format("{}", fmt::join(changes, ", and "));
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
  Readings(std::span<const HandeyePair> views, CameraMount mount, const HandeyeScale& scale,
           const RobotForm& form)
      : mount_(mount), scale_(scale), form_(form), views_(views.begin(), views.end()) {
    given_ = level(views_);
  }

  // A change more has to fit much better than the changes before it.
  std::optional<BetterReading> best() {
    for (const RotationReading& rotation : kRotations)
      for (const LengthReading& length : length_readings(form_))
        for (const bool inverse : {false, true})
          if (allows(form_, rotation)) try_reading(rotation, length, inverse);
    for (const int shift : {-2, -1, 1, 2}) try_shift(shift);
    std::optional<BetterReading> best;
    double least = given_;
    for (std::optional<Tried>& tried : tried_) {
      if (!tried) continue;
      BetterReading& reading = tried->reading;
      reading.reading.times_better = given_ / tried->level;
      reading.is_certain = is_certain(*tried, least, views_.size());
      const bool is_better = best ? reading.reading.times_better > best->reading.times_better
                                  : reading.reading.times_better > 1;
      if (!reading.is_certain && (!is_better || (best && best->is_certain))) continue;
      if (reading.is_certain) least = tried->level;
      best = std::move(reading);
    }
    return best;
  }

 private:
  struct Tried {
    BetterReading reading;
    double level = 0;
  };

  double level(std::span<const HandeyePair> views) const {
    const auto start = closed_form_places(views, mount_, scale_);
    constexpr double kExact = 1e-9;  // numeric: rounding
    return start ? std::max(level_of(*start), kExact * scale_.distance_m)
                 : std::numeric_limits<double>::infinity();
  }

  // A reading that would be refused as an answer is none, however bad the others are.
  bool is_certain(const Tried& tried, double than, std::size_t num_views) const {
    const double better = than / tried.level;
    return better >= policy::kReadingBetter && is_no_chance(better, num_views) &&
           tried.level <= policy::kHandeyeRefused * scale_.distance_m;
  }

  // Keeps the best one of each number of changes.
  void keep(std::size_t num_changes, Tried tried) {
    std::optional<Tried>& best = tried_[num_changes - 1];
    if (!best || tried.level < best->level) best = std::move(tried);
  }

  void try_reading(const RotationReading& rotation, const LengthReading& length, bool inverse) {
    std::vector<std::string> changes = {rotation.change, length.change};
    if (inverse)
      changes.push_back(
          fmt::format("the poses are hand_from_base, not base_from_hand (or the camera is {}: "
                      "--mount {})",
                      mount_ == CameraMount::hand ? "beside the robot" : "on the hand",
                      mount_ == CameraMount::hand ? "base" : "hand"));
    std::erase(changes, "");
    if (changes.empty()) return;
    const auto read = [rotation, factor = length.factor, inverse](const HandeyePair& pair) {
      const Pose changed(rotation_of(pair, rotation), factor * pair.base_from_hand.translation());
      return inverse ? changed.inverse() : changed;
    };
    std::vector<HandeyePair> views = views_;
    for (HandeyePair& v : views) v.base_from_hand = read(v);
    keep(changes.size(), {{{joined(changes)}, read}, level(views)});
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
    Tried tried{{{change}, nullptr, true}, level(views)};
    if (is_certain(tried, given_, views.size())) keep(1, std::move(tried));
  }

  CameraMount mount_;
  HandeyeScale scale_;
  RobotForm form_;
  std::vector<HandeyePair> views_;
  double given_ = 0;
  std::array<std::optional<Tried>, 3> tried_;  // by the number of changes
};

}  // namespace

bool can_show_reading(std::size_t num_views) {
  return is_no_chance(policy::kReadingBetter, num_views);
}

std::optional<BetterReading> better_reading(std::span<const HandeyePair> views, CameraMount mount,
                                            const HandeyeScale& scale, const RobotForm& form) {
  if (views.size() < 3) return std::nullopt;
  constexpr std::size_t kMost = 24;  // views: a limit of work
  return Readings(views.first(std::min(views.size(), kMost)), mount, scale, form).best();
}

}  // namespace tagcal::internal
