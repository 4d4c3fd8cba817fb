#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "job/view_report.hpp"
#include "report/view_text.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/viewing/projection.hpp"

namespace tagcal::tools {
namespace {

constexpr const char* kLocked = "straight up or down: one of the angles is free (gimbal lock)";

void note_lock(Json& angles, bool gimbal_lock) {
  if (gimbal_lock) angles["gimbal_lock"] = kLocked;
}

Json look_at_json(const Pose& pose, double distance_m) {
  const LookAt view = look_at(pose, distance_m);
  return {{"eye_m", array(view.eye)}, {"target_m", array(view.target)}, {"up", array(view.up)}};
}

Json orbit_json(const Pose& pose, double distance_m) {
  const Orbit o = orbit(pose, distance_m);
  Json result = {{"target_m", array(o.target)},
                 {"distance_m", o.distance_m},
                 {"azimuth_deg", degrees(o.azimuth_rad)},
                 {"elevation_deg", degrees(o.elevation_rad)},
                 {"twist_deg", degrees(o.twist_rad)}};
  note_lock(result, o.gimbal_lock);
  return result;
}

Json angles_json(const Pose& pose) {
  const RollPitchYaw angles = camera_angles(pose);
  Json result = {{"centre_m", array(pose.inverse().translation())},
                 {"roll_deg", degrees(angles.roll_rad)},
                 {"pitch_deg", degrees(angles.pitch_rad)},
                 {"yaw_deg", degrees(angles.yaw_rad)}};
  note_lock(result, angles.gimbal_lock);
  return result;
}

// The turns of a camera of graphics in a world with y up (our x, z, -y):
// eye_from_world = Rz Rx Ry T(-centre).
Json eye_turns_json(const ViewingPipeline& pipeline) {
  const Eigen::Matrix3d r = pipeline.eye_from_camera.topLeftCorner<3, 3>() *
                            pipeline.camera_from_world.rotation_matrix() *
                            rotation_about_x(std::numbers::pi / 2).rotation_matrix();
  Json result = {{"about_z_deg", degrees(std::atan2(-r(0, 1), r(1, 1)))},
                 {"about_x_deg", degrees(std::asin(std::clamp(r(2, 1), -1.0, 1.0)))},
                 {"about_y_deg", degrees(std::atan2(-r(2, 0), r(2, 2)))}};
  note_lock(result, camera_angles(pipeline.camera_from_world).gimbal_lock);
  return result;
}

Json aircraft_json(const Pose& pose) {
  const Aircraft a = aircraft(pose.inverse() * camera_from_aircraft());
  Json result = {{"rho_m", a.position.rho},
                 {"theta_deg", degrees(a.position.theta_rad)},
                 {"phi_deg", degrees(a.position.phi_rad)},
                 {"yaw_deg", degrees(a.yaw_rad)},
                 {"pitch_deg", degrees(a.pitch_rad)},
                 {"roll_deg", degrees(a.roll_rad)}};
  note_lock(result, a.gimbal_lock);
  return result;
}

Json field_of_view_json(const Camera& camera) {
  const auto fov = field_of_view(camera);
  if (!fov) return {};
  return {{"width", degrees(fov->horizontal_rad)},
          {"height", degrees(fov->vertical_rad)},
          {"diagonal", degrees(fov->diagonal_rad)}};
}

Json chain_json(const ViewReport& report) {
  Json chain = Json::array();
  if (!report.point.board) return chain;
  const Eigen::Vector3d& x = report.followed.in_world;
  for (const ShownFrame& frame : frames_of_board(report, *report.point.board))
    chain.push_back({{"name", frame.name},
                     {"parent_from_frame", rows(frame.parent_from_frame.matrix())},
                     {"world_from_frame", rows(frame.world_from_frame.matrix())},
                     {"point_m", array(Eigen::Vector3d(frame.frame_from_world * x))}});
  return chain;
}

Json vanishing_json(const ViewingPipeline& pipeline) {
  static constexpr const char* kNames[] = {"none", "one-point", "two-point", "three-point"};
  const Lens& lens = pipeline.camera.lens;
  const int num_axes = num_vanishing_axes(lens, pipeline.camera_from_world.rotation());
  const bool parallel = pipeline.volume.projection == Projection::parallel;
  Json result = {{"kind", parallel ? "parallel projection: none"
                                   : fmt::format("{} perspective", kNames[num_axes])},
                 {"num_vanishing_axes", num_axes}};
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d direction =
        pipeline.camera_from_world.rotation() * Eigen::Vector3d::Unit(axis);
    int count = 0;
    for (const auto& pixel : vanishing_points(lens, direction))
      result[fmt::format("{}{}_px", "xyz"[axis], count++ ? "_back" : "")] = array(pixel);
  }
  return result;
}

}  // namespace

Json camera_steps(const ViewReport& report) {
  const Pose& pose = report.pipeline.camera_from_world;
  const double depth = report.followed.in_camera.z();
  const double distance_m = depth > 0 ? depth : 1;  // of the target on the axis
  return {{"frames_of_board", chain_json(report)},
          {"look_at", look_at_json(pose, distance_m)},
          {"orbit", orbit_json(pose, distance_m)},
          {"roll_pitch_yaw", angles_json(pose)},
          {"eye_turns_in_a_world_with_y_up", eye_turns_json(report.pipeline)},
          {"aircraft", aircraft_json(pose)},
          {"field_of_view_deg", field_of_view_json(report.pipeline.camera)},
          {"vanishing_points", vanishing_json(report.pipeline)}};
}

}  // namespace tagcal::tools
