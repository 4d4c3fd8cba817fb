#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/estimate/handeye_types.hpp"

// Private to io: what the columns of a table of poses are (robot_poses.hpp).

namespace tagcal::internal {

enum class PoseColumn {
  ignored,
  image,
  time,
  x,
  y,
  z,
  qw,
  qx,
  qy,
  qz,
  rx,
  ry,
  rz,
  roll,
  pitch,
  yaw,
  m00,
  m01,
  m02,
  m10,
  m11,
  m12,
  m20,
  m21,
  m22
};
constexpr std::size_t kPoseColumns = static_cast<std::size_t>(PoseColumn::m22) + 1;

// The columns of a line.
class PoseColumns {
 public:
  // Throws Error("columns: ..") for names that do not make a pose. `is_strict`: unknown names are
  // errors.
  PoseColumns(const std::vector<std::string>& names, bool is_strict);

  std::size_t size() const { return columns_.size(); }
  bool has(PoseColumn column) const { return place(column).has_value(); }
  std::optional<std::size_t> place(PoseColumn column) const {
    return places_[static_cast<std::size_t>(column)];
  }

  // The fields of a line as numbers; throws Error("qw: must be a finite number, got ..").
  double number(const std::vector<std::string_view>& fields, PoseColumn column) const;
  Pose pose(const std::vector<std::string_view>& fields) const;
  RobotForm form() const;
  // The numbers of the rotation; of a matrix zeros.
  RotationNumbers rotation_numbers(const std::vector<std::string_view>& fields) const;

 private:
  struct Column {
    PoseColumn column = PoseColumn::ignored;
    double factor = 1;  // to metres, radians, seconds
    std::string name;
  };
  static Column column_of(const std::string& name, bool is_strict);
  void check() const;
  bool has_all(std::initializer_list<PoseColumn> columns) const;
  Eigen::Quaterniond rotation(const std::vector<std::string_view>& fields) const;

  std::vector<Column> columns_;
  std::array<std::optional<std::size_t>, kPoseColumns> places_;
};

}  // namespace tagcal::internal
