#include "draw/outside_view.hpp"

#include <algorithm>
#include <cmath>

#include "job/view_report.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/scene/surfaces.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// In lengths of the diagonal of camera, scene and point: the greatest distance of the far plane's
// corners from their middle at which it is drawn, that at which the volume is cut otherwise, that
// of a drawn frame, and the length of drawn axes.
constexpr double kFarReach = 2;
constexpr double kCutReach = 0.8;
constexpr double kFrameReach = 2;
constexpr double kAxisLength = 0.1;
constexpr double kFilled = 0.84;  // share of the panel; the rest is for names
constexpr std::size_t kMostFrames = 12;

}  // namespace

OutsideView::OutsideView(const ViewReport& report)
    : report_(report),
      world_from_eye_(
          (report.pipeline.eye_from_camera * report.pipeline.camera_from_world.matrix()).inverse()),
      scene_box_(scene_box()),
      drawn_depth_m_(find_drawn_depth_m()) {
  find_frames();
}

Vector3d OutsideView::sight_start_in_eye() const {
  const Vector3d& x = report_.followed.in_eye;
  const bool parallel = report_.pipeline.volume.projection == Projection::parallel;
  return parallel ? Vector3d(x.x(), x.y(), 0) : Vector3d::Zero();
}

std::vector<Vector3d> OutsideView::cross_section(double depth_m) const {
  ViewVolume volume = report_.pipeline.volume;
  volume.far_m = depth_m;
  const std::vector<Vector3d> all = corners(volume);
  std::vector<Vector3d> result;
  for (std::size_t i = 4; i < 8; ++i) result.push_back(in_world(all[i]));  // numeric: far corners
  return result;
}

Eigen::AlignedBox3d OutsideView::scene_box() const {
  Eigen::AlignedBox3d box(report_.pipeline.camera_from_world.inverse().translation());
  box.extend(report_.followed.in_world);
  box.extend(in_world(sight_start_in_eye()));
  for (const Sheet& sheet : sheets(report_.scene))
    for (const Vector3d& corner : sheet.corners) box.extend(corner);
  for (const auto& [id, x] : points_in_world(report_.scene.boards)) box.extend(x);
  return box;
}

bool OutsideView::is_near(const Vector3d& x, double reach) const {
  return (x - scene_box_.center()).norm() <= reach * scene_box_.diagonal().norm();
}

double OutsideView::find_drawn_depth_m() const {
  const auto fits = [&](double depth, double reach) {
    return std::ranges::all_of(cross_section(depth),
                               [&](const Vector3d& x) { return is_near(x, reach); });
  };
  double low = 0, high = report_.pipeline.volume.far_m;
  if (fits(high, kFarReach)) return high;
  for (int i = 0; i < 60; ++i) {  // numeric: bisection to the last bits
    const double middle = (low + high) / 2;
    (fits(middle, kCutReach) ? low : high) = middle;
  }
  return low;
}

double OutsideView::image_depth_m() const {
  const double near = report_.pipeline.volume.near_m;
  const double point = std::max(near, -report_.followed.in_eye.z());
  return std::min(std::sqrt(near * point), drawn_depth_m_);
}

void OutsideView::find_frames() {
  std::vector<DrawnFrame> all = {{"world", Affine::Identity()},
                                 {"camera", affine(report_.pipeline.camera_from_world.inverse())}};
  for (const ShownFrame& frame : shown_frames(report_))
    if (!frame.board || frame.board == report_.point.board)
      all.push_back({frame.name, frame.world_from_frame});
  for (DrawnFrame& frame : all)
    if (is_near(frame.world_from_frame.translation(), kFrameReach) && frames_.size() < kMostFrames)
      frames_.push_back(std::move(frame));
    else
      left_out_ += (left_out_.empty() ? "" : ", ") + frame.name;
}

Vector3d OutsideView::axis_tip(const DrawnFrame& frame, int axis) const {
  return frame.world_from_frame.translation() +
         kAxisLength * scene_box_.diagonal().norm() *
             frame.world_from_frame.linear().col(axis).normalized();
}

std::vector<Vector3d> OutsideView::points() const {
  std::vector<Vector3d> points = cross_section(drawn_depth_m_);
  for (int i = 0; i < 8; ++i)  // numeric: corners of a box
    points.push_back(scene_box_.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)));
  for (const DrawnFrame& frame : frames_)
    for (int axis = 0; axis < 3; ++axis) points.push_back(axis_tip(frame, axis));
  return points;
}

Pose OutsideView::camera_from_world() const {
  Eigen::AlignedBox3d box;
  for (const Vector3d& x : points()) box.extend(x);
  Vector3d along = report_.pipeline.camera_from_world.inverse().rotation() * Vector3d::UnitZ();
  along.z() = 0;
  if (along.norm() < 1e-3) along = Vector3d::UnitY();  // numeric: straight down
  along.normalize();
  const Vector3d from = along.cross(Vector3d::UnitZ()) - 0.4 * along + 0.5 * Vector3d::UnitZ();
  const Vector3d eye = box.center() + 2 * box.diagonal().norm() * from.normalized();
  return camera_from_world_looking_at(eye, box.center(), Vector3d::UnitZ());
}

Camera OutsideView::camera(const PanelSize& size) const {
  const Pose pose = camera_from_world();
  Eigen::AlignedBox2d seen;
  for (const Vector3d& x : points()) seen.extend((pose * x).hnormalized());
  const Vector2d panel(size.width, size.height);
  const double focal = kFilled * panel.cwiseQuotient(seen.sizes()).minCoeff();
  const Vector2d centre = panel / 2 - focal * seen.center();
  return {pinhole(focal, focal, centre.x(), centre.y()),
          {static_cast<int>(size.width), static_cast<int>(size.height)}};
}

}  // namespace tagcal::tools
