#include "tagcal/io/scene/scene_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "tagcal/geometry/transform.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"
#include "tagcal/viewing/projection.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector3d;
using PoseOverViews = std::function<Pose(double t)>;

constexpr double kHuge = std::numeric_limits<double>::max();

double degrees_or(const std::optional<YamlValue>& value, double otherwise_deg,
                  double most_deg = kHuge) {
  return radians(value ? value->number_in(-most_deg, most_deg) : otherwise_deg);
}

VectorOverViews vectors_or(const std::optional<YamlValue>& value, const Vector3d& otherwise) {
  return value ? vectors_over_views(*value) : VectorOverViews({otherwise});
}

// A number, or a list of at most 1000 numbers.
NumberOverViews numbers_over_views(const YamlValue& value) {
  return NumberOverViews(value.is_list() ? value.numbers(1, limits::kMaxValuesOfPath)
                                         : std::vector<double>{value.number()});
}

RingPath read_ring(const YamlValue& value) {
  value.allow_only({"type", "frame", "centre_m", "radius_m", "start_deg", "end_deg", "target_m"});
  RingPath path;
  path.centre = vector_or(value.find("centre_m"), Vector3d::Zero());
  path.radius_m = value.at("radius_m").positive();
  path.start_rad = degrees_or(value.find("start_deg"), 0, 3600);
  path.end_rad = degrees_or(value.find("end_deg"), 360, 3600);
  path.target = vector_or(value.find("target_m"), Vector3d::Zero());
  return path;
}

void check_order(const YamlValue& value, double low, double high, const char* quantity) {
  if (low > high) {
    value.fail_plainly(fmt::format("min_{0}: must not be above max_{0}", quantity));
  }
}

DomePath read_dome(const YamlValue& value) {
  value.allow_only({"type", "frame", "target_m", "min_distance_m", "max_distance_m",
                    "min_azimuth_deg", "max_azimuth_deg", "min_elevation_deg",
                    "max_elevation_deg"});
  DomePath path;
  path.target = vector_or(value.find("target_m"), Vector3d::Zero());
  path.min_distance_m = value.at("min_distance_m").positive();
  const auto max_distance = value.find("max_distance_m");
  path.max_distance_m = max_distance ? max_distance->positive() : path.min_distance_m;
  path.min_azimuth_rad = degrees_or(value.find("min_azimuth_deg"), 0, 720);
  path.max_azimuth_rad = degrees_or(value.find("max_azimuth_deg"), 360, 720);
  path.min_elevation_rad = radians(value.at("min_elevation_deg").number_in(-90, 90));
  path.max_elevation_rad = degrees_or(value.find("max_elevation_deg"), 90, 90);
  check_order(value, path.min_distance_m, path.max_distance_m, "distance_m");
  check_order(value, path.min_azimuth_rad, path.max_azimuth_rad, "azimuth_deg");
  check_order(value, path.min_elevation_rad, path.max_elevation_rad, "elevation_deg");
  return path;
}

LinePath read_line(const YamlValue& value) {
  value.allow_only({"type", "frame", "from_m", "to_m", "target_m"});
  return {read_vector(value.at("from_m")), read_vector(value.at("to_m")),
          vector_or(value.find("target_m"), Vector3d::Zero())};
}

ExplicitPath read_poses(const YamlValue& value) {
  value.allow_only({"type", "frame", "camera_from_world"});
  ExplicitPath path;
  for (const YamlValue& pose : value.at("camera_from_world").items(1, limits::kMaxViews)) {
    path.camera_from_world.push_back(read_pose(pose));
  }
  return path;
}

PoseOverViews read_look_at(const YamlValue& value) {
  value.allow_only({"type", "frame", "eye_m", "target_m", "up"});
  const VectorOverViews eye = vectors_over_views(value.at("eye_m"));
  const VectorOverViews target = vectors_or(value.find("target_m"), Vector3d::Zero());
  const VectorOverViews up = vectors_or(value.find("up"), Vector3d::UnitZ());
  return [=](double t) { return camera_from_world_looking_at(eye.at(t), target.at(t), up.at(t)); };
}

PoseOverViews read_orbit(const YamlValue& value) {
  value.allow_only(
      {"type", "frame", "target_m", "distance_m", "azimuth_deg", "elevation_deg", "twist_deg"});
  const VectorOverViews target = vectors_or(value.find("target_m"), Vector3d::Zero());
  const NumberOverViews distance = numbers_over_views(value.at("distance_m"));
  const NumberOverViews azimuth = degrees_over_views(value.find("azimuth_deg"));
  const NumberOverViews elevation = degrees_over_views(value.find("elevation_deg"));
  const NumberOverViews twist = degrees_over_views(value.find("twist_deg"));
  return [=](double t) {
    return camera_from_world_on_orbit(
        {target.at(t), distance.at(t), azimuth.at(t), elevation.at(t), twist.at(t)});
  };
}

std::function<Aircraft(double t)> read_aircraft(const YamlValue& value) {
  value.allow_only(
      {"type", "frame", "rho_m", "theta_deg", "phi_deg", "yaw_deg", "pitch_deg", "roll_deg"});
  const NumberOverViews rho = numbers_over_views(value.at("rho_m"));
  const NumberOverViews theta = degrees_over_views(value.find("theta_deg"));
  const NumberOverViews phi = degrees_over_views(value.find("phi_deg"));
  const NumberOverViews yaw = degrees_over_views(value.find("yaw_deg"));
  const NumberOverViews pitch = degrees_over_views(value.find("pitch_deg"));
  const NumberOverViews roll = degrees_over_views(value.find("roll_deg"));
  return [=](double t) {
    return Aircraft{{rho.at(t), theta.at(t), phi.at(t)}, yaw.at(t), pitch.at(t), roll.at(t)};
  };
}

PoseOverViews read_angles(const YamlValue& value) {
  value.allow_only({"type", "frame", "centre_m", "roll_deg", "pitch_deg", "yaw_deg"});
  const VectorOverViews centre = vectors_or(value.find("centre_m"), Vector3d::Zero());
  const NumberOverViews roll = degrees_over_views(value.find("roll_deg"));
  const NumberOverViews pitch = degrees_over_views(value.find("pitch_deg"));
  const NumberOverViews yaw = degrees_over_views(value.find("yaw_deg"));
  return [=](double t) {
    return camera_from_world_with_angles({roll.at(t), pitch.at(t), yaw.at(t)}, centre.at(t));
  };
}

DrawnView read_drawn_view(const YamlValue& value) {
  const std::string name = value.text();
  if (name == "plan") return DrawnView::plan;
  if (name == "front_elevation") return DrawnView::front_elevation;
  if (name == "side_elevation") return DrawnView::side_elevation;
  if (name == "isometric") return DrawnView::isometric;
  value.fail("must be plan, front_elevation, side_elevation or isometric");
}

PoseOverViews read_drawn(const YamlValue& value) {
  value.allow_only({"type", "frame", "view", "target_m", "distance_m"});
  const Eigen::Quaterniond rotation = camera_from_world_drawn(read_drawn_view(value.at("view")));
  const VectorOverViews target = vectors_or(value.find("target_m"), Vector3d::Zero());
  const double distance = not_negative_or(value.find("distance_m"), 0);
  return [=](double t) {
    return translation({0, 0, distance}) * Pose(rotation, Vector3d::Zero()) *
           translation(-target.at(t));
  };
}

FunctionPath read_window(const YamlValue& value, const ImageSize& size) {
  value.allow_only({"type", "frame", "lower_left_m", "lower_right_m", "upper_left_m", "eye_m"});
  const WindowInWorld window{read_vector(value.at("lower_left_m")),
                             read_vector(value.at("lower_right_m")),
                             read_vector(value.at("upper_left_m"))};
  const VectorOverViews eye = vectors_over_views(value.at("eye_m"));
  return {[=](double t) { return camera_behind(window, eye.at(t), size).camera_from_world; },
          [=](double t) { return camera_behind(window, eye.at(t), size).camera.lens; }};
}

// Throws, with the place in the file, if the path has no value at the first view.
FunctionPath checked(FunctionPath path, const YamlValue& value) {
  value.within([&] { path.camera_from_world(0); });
  return path;
}

FunctionPath read_still(const YamlValue& value, const std::string& type, const ImageSize& size) {
  if (type == "look_at") return {read_look_at(value), {}};
  if (type == "orbit") return {read_orbit(value), {}};
  if (type == "roll_pitch_yaw") return {read_angles(value), {}};
  if (type == "drawn") return {read_drawn(value), {}};
  if (type == "window") return read_window(value, size);
  if (type == "aircraft")
    return {[aircraft = read_aircraft(value)](double t) {
              return camera_from_world_in_aircraft(aircraft(t));
            },
            {}};
  if (type == "frame") {
    value.allow_only({"type", "frame"});
    return {[](double) { return Pose(); }, {}};
  }
  value.at("type").fail(
      "must be ring, dome, line, poses, look_at, orbit, aircraft, roll_pitch_yaw, drawn, window or "
      "frame");
}

}  // namespace

CameraPath read_path(const YamlValue& value, const ImageSize& image_size) {
  const std::string type = value.at("type").text();
  if (type == "ring") return read_ring(value);
  if (type == "dome") return read_dome(value);
  if (type == "line") return read_line(value);
  if (type == "poses") return read_poses(value);
  return checked(read_still(value, type, image_size), value);
}

int read_num_views(const YamlValue& top, const CameraPath& path) {
  const auto views = top.find("views");
  if (const auto* poses = std::get_if<ExplicitPath>(&path)) {
    const int num_poses = static_cast<int>(poses->camera_from_world.size());
    return views ? views->whole(1, num_poses) : num_poses;
  }
  if (!views && std::holds_alternative<FunctionPath>(path)) return 1;
  return top.at("views").whole(1, limits::kMaxViews);
}

Pose read_viewpoint(std::string_view kind, const YamlValue& value) {
  return value.within([&] {
    if (kind == "aircraft") return world_from_aircraft(read_aircraft(value)(0));
    return (kind == "orbit" ? read_orbit(value) : read_look_at(value))(0).inverse();
  });
}

NumberOverViews degrees_over_views(const std::optional<YamlValue>& value) {
  std::vector<double> angles = {0};
  if (value)
    angles = value->is_list() ? value->numbers(1, limits::kMaxValuesOfPath)
                              : std::vector{value->number()};
  for (double& angle : angles) angle = radians(angle);
  return NumberOverViews(std::move(angles));
}

VectorOverViews vectors_over_views(const YamlValue& value) {
  const std::vector<YamlValue> items = value.items(1, limits::kMaxValuesOfPath);
  if (!items[0].is_list()) return VectorOverViews({read_vector(value)});
  std::vector<Eigen::Vector3d> vectors;
  for (const YamlValue& item : items) vectors.push_back(read_vector(item));
  return VectorOverViews(std::move(vectors));
}

}  // namespace tagcal::internal
