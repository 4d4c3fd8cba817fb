#include "tagcal/io/dataset/pose_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tagcal/error.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector3d;
using enum PoseColumn;

struct NamedColumn {
  std::string_view name;
  PoseColumn column;
  double factor = 1;
};

constexpr NamedColumn kNames[] = {{"image", image},
                                  {"name", image},
                                  {"-", ignored},
                                  {"time_s", time},
                                  {"time_ms", time, 1e-3},
                                  {"time_us", time, 1e-6},
                                  {"time_ns", time, 1e-9},
                                  {"x_m", x},
                                  {"y_m", y},
                                  {"z_m", z},
                                  {"x_mm", x, 1e-3},
                                  {"y_mm", y, 1e-3},
                                  {"z_mm", z, 1e-3},
                                  {"qw", qw},
                                  {"qx", qx},
                                  {"qy", qy},
                                  {"qz", qz},
                                  {"rx_rad", rx},
                                  {"ry_rad", ry},
                                  {"rz_rad", rz},
                                  {"rx_deg", rx, kDegree},
                                  {"ry_deg", ry, kDegree},
                                  {"rz_deg", rz, kDegree},
                                  {"roll_rad", roll},
                                  {"pitch_rad", pitch},
                                  {"yaw_rad", yaw},
                                  {"roll_deg", roll, kDegree},
                                  {"pitch_deg", pitch, kDegree},
                                  {"yaw_deg", yaw, kDegree},
                                  {"m00", m00},
                                  {"m01", m01},
                                  {"m02", m02},
                                  {"m10", m10},
                                  {"m11", m11},
                                  {"m12", m12},
                                  {"m20", m20},
                                  {"m21", m21},
                                  {"m22", m22},
                                  {"m03_m", x},
                                  {"m13_m", y},
                                  {"m23_m", z},
                                  {"m03_mm", x, 1e-3},
                                  {"m13_mm", y, 1e-3},
                                  {"m23_mm", z, 1e-3}};

// ROS: geometry_msgs in metres (REP 103), stamps of `rostopic echo -p` in nanoseconds.
constexpr NamedColumn kRosEndings[] = {{"header.stamp", time, 1e-9},
                                       {"translation.x", x},
                                       {"translation.y", y},
                                       {"translation.z", z},
                                       {"position.x", x},
                                       {"position.y", y},
                                       {"position.z", z},
                                       {"rotation.x", qx},
                                       {"rotation.y", qy},
                                       {"rotation.z", qz},
                                       {"rotation.w", qw},
                                       {"orientation.x", qx},
                                       {"orientation.y", qy},
                                       {"orientation.z", qz},
                                       {"orientation.w", qw}};

// Names that have a unit elsewhere.
bool lacks_unit(std::string_view name) {
  return std::ranges::any_of(kNames, [&](const NamedColumn& c) {
    return c.name.size() > name.size() + 1 && c.name.starts_with(name) &&
           c.name[name.size()] == '_';
  });
}

}  // namespace

PoseColumns::Column PoseColumns::column_of(const std::string& name, bool is_strict) {
  const auto known = std::ranges::find(kNames, std::string_view(name), &NamedColumn::name);
  if (known != std::end(kNames)) return {known->column, known->factor, name};
  std::string dotted = name;
  std::ranges::replace(dotted, '/', '.');
  for (const NamedColumn& ros : kRosEndings)
    if (dotted.ends_with(ros.name)) return {ros.column, ros.factor, name};
  if (lacks_unit(name))
    throw Error(fmt::format(
        "column {}: has no unit; name it {} with --robot-format, or in the "
        "first line",
        shown(name),
        name.starts_with("time")                    ? "time_s, time_ms, time_us or time_ns"
        : name.size() == 1 || name.starts_with('m') ? name + "_m or " + name + "_mm"
                                                    : name + "_rad or " + name + "_deg"));
  if (is_strict)
    throw Error(fmt::format("column {}: is not known; - is one that is not read", shown(name)));
  return {ignored, 1, name};
}

PoseColumns::PoseColumns(const std::vector<std::string>& names, bool is_strict) {
  for (const std::string& name : names) {
    columns_.push_back(column_of(name, is_strict));
    const PoseColumn column = columns_.back().column;
    if (column == ignored) continue;
    auto& place = places_[static_cast<std::size_t>(column)];
    if (place)
      throw Error(
          fmt::format("columns {} and {} are the same", shown(columns_[*place].name), shown(name)));
    place = columns_.size() - 1;
  }
  check();
}

bool PoseColumns::has_all(std::initializer_list<PoseColumn> columns) const {
  return std::ranges::all_of(columns, [&](PoseColumn c) { return has(c); });
}

void PoseColumns::check() const {
  if (!has_all({x, y, z})) throw Error("needs the columns x_m y_m z_m, or x_mm y_mm z_mm");
  const int rotations = has_all({qw, qx, qy, qz}) + has_all({rx, ry, rz}) +
                        has_all({roll, pitch, yaw}) +
                        has_all({m00, m01, m02, m10, m11, m12, m20, m21, m22});
  if (rotations != 1)
    throw Error(
        fmt::format("needs one rotation: columns qw qx qy qz, or rx_rad ry_rad rz_rad (or "
                    "_deg), or roll_deg pitch_deg yaw_deg (or _rad), or m00 m01 .. m22, "
                    "has {}",
                    rotations == 0 ? "none" : "several"));
  if (has(image) && has(time))
    throw Error("has columns image and time: poses belong to pictures by one");
}

double PoseColumns::number(const std::vector<std::string_view>& fields, PoseColumn column) const {
  const std::size_t i = *place(column);
  const auto value = parse_number(fields[i]);
  if (!value)
    throw Error(fmt::format("{}: must be a finite number, got {}", shown(columns_[i].name),
                            shown(fields[i])));
  return columns_[i].factor * *value;
}

RobotForm PoseColumns::form() const {
  RobotForm form;
  form.length_unit_m = columns_[*place(x)].factor;
  form.rotation = has(qw)     ? (*place(qw) < *place(qx) ? RotationForm::wxyz : RotationForm::xyzw)
                  : has(rx)   ? RotationForm::vector
                  : has(roll) ? RotationForm::roll_pitch_yaw
                              : RotationForm::matrix;
  if (has(rx) || has(roll)) form.in_degrees = columns_[*place(has(rx) ? rx : roll)].factor != 1;
  return form;
}

RotationNumbers PoseColumns::rotation_numbers(const std::vector<std::string_view>& fields) const {
  const auto at = [&](PoseColumn column) { return number(fields, column); };
  if (has(qw)) return {at(qw), at(qx), at(qy), at(qz)};
  if (has(rx)) return {at(rx), at(ry), at(rz), 0};
  if (has(roll)) return {at(roll), at(pitch), at(yaw), 0};
  return {};
}

Eigen::Quaterniond PoseColumns::rotation(const std::vector<std::string_view>& fields) const {
  const auto at = [&](PoseColumn column) { return number(fields, column); };
  if (has(qw)) {
    const Eigen::Quaterniond q(at(qw), at(qx), at(qy), at(qz));
    if (!(std::abs(q.norm() - 1) <= kRotationTolerance))
      throw Error(fmt::format("the quaternion must have unit length, got {:.4g}", q.norm()));
    return q;
  }
  if (has(rx)) {
    const Vector3d v(at(rx), at(ry), at(rz));
    if (v.norm() > 2 * std::numbers::pi + kRotationTolerance)
      throw Error(
          fmt::format("the rotation vector must be at most a full turn, got {:.4g} rad: are "
                      "these degrees (rx_deg ry_deg rz_deg)?",
                      v.norm()));
    return exp_rotation(v);
  }
  if (has(roll)) {
    RollPitchYaw angles;
    angles.roll_rad = at(roll);
    angles.pitch_rad = at(pitch);
    angles.yaw_rad = at(yaw);
    if (std::max({std::abs(angles.roll_rad), std::abs(angles.pitch_rad),
                  std::abs(angles.yaw_rad)}) > 2 * std::numbers::pi + kRotationTolerance)
      throw Error("roll, pitch and yaw must be at most a full turn: are these degrees (roll_deg)?");
    return rotation_from_roll_pitch_yaw(angles);
  }
  Eigen::Matrix3d m;
  m << at(m00), at(m01), at(m02), at(m10), at(m11), at(m12), at(m20), at(m21), at(m22);
  return rotation_from_matrix(m, "the matrix m00 .. m22");
}

Pose PoseColumns::pose(const std::vector<std::string_view>& fields) const {
  return {rotation(fields), {number(fields, x), number(fields, y), number(fields, z)}};
}

}  // namespace tagcal::internal
