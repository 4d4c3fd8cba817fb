#include "tagcal/io/scene_file.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <limits>
#include <numbers>

#include "tagcal/error.hpp"
#include "tagcal/io/yaml/yaml_boards.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector3d;
using OptionalValue = std::optional<YamlValue>;

constexpr int kMaxViews = 100'000;
constexpr double kHuge = std::numeric_limits<double>::max();

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

double not_negative_or(const OptionalValue& value, double otherwise) {
  return value ? value->not_negative() : otherwise;
}

double level_or(const OptionalValue& value, double otherwise) {
  return value ? value->number_in(0, 1) : otherwise;
}

Vector3d vector_or_zero(const OptionalValue& value) {
  return value ? read_vector(*value) : Vector3d::Zero();
}

double degrees_or(const OptionalValue& value, double otherwise_deg, double most_deg = kHuge) {
  return radians(value ? value->number_in(-most_deg, most_deg) : otherwise_deg);
}

// Focal length of an ideal pinhole or equidistant lens with this field of view over the width.
double focal_of(const YamlValue& field_of_view_deg, const Model& model, const ImageSize& size) {
  const bool fisheye = model.lens_type() == LensType::fisheye;
  const double degrees = field_of_view_deg.positive();
  const double limit = fisheye ? 360 : 180;
  if (degrees >= limit) field_of_view_deg.fail(fmt::format("must be below {}", limit));
  if (fisheye) return size.width / radians(degrees);
  return focal_from_field_of_view_px(radians(degrees), size.width);
}

void read_focal(const YamlValue& value, const Model& model, CameraNumbers& numbers) {
  const auto f = value.find("f");
  const auto field_of_view = value.find("field_of_view_deg");
  const bool has_both = value.find("fx").has_value() || value.find("fy").has_value();
  if (int{f.has_value()} + int{field_of_view.has_value()} + int{has_both} != 1) {
    value.fail_plainly("needs one of f, fx and fy, field_of_view_deg");
  }
  if (has_both) {
    numbers.fx = value.at("fx").positive();
    numbers.fy = value.at("fy").positive();
  } else {
    numbers.fx = f ? f->positive() : focal_of(*field_of_view, model, numbers.image_size);
    numbers.fy = numbers.fx;
  }
}

std::size_t num_free_distortion(const Model& model) {
  std::size_t count = 0;
  for (const FreeParameter& parameter : model.free()) count += parameter.lens_parameters[0] >= 4;
  return count;
}

// A scene with its camera only.
Scene read_camera(const YamlValue& value) {
  value.allow_only(
      {"image_size", "model", "f", "fx", "fy", "field_of_view_deg", "cx", "cy", "distortion"});
  const Model& model = read_model(value.at("model"));
  CameraNumbers numbers;
  numbers.image_size = read_image_size_value(value.at("image_size"));
  read_focal(value, model, numbers);
  const Eigen::Vector2d centre = image_centre(numbers.image_size);
  const auto cx = value.find("cx");
  const auto cy = value.find("cy");
  numbers.cx = cx ? cx->number() : centre.x();
  numbers.cy = cy ? cy->number() : centre.y();
  if (const auto distortion = value.find("distortion")) {
    const std::size_t most = num_free_distortion(model);
    numbers.distortion = distortion->numbers(0, 100);
    if (numbers.distortion.size() > most) {
      distortion->fail(
          fmt::format("must have at most the {} coefficients of model {}", most, model.name()));
    }
  }
  return {make_camera(numbers, model, value), std::string(model.name()), {}, {}, {}, {}, 1, {}};
}

Occluder read_occluder(const YamlValue& value) {
  value.allow_only({"corners", "level"});
  Occluder occluder;
  occluder.level = level_or(value.find("level"), occluder.level);
  const YamlValue list = value.at("corners");
  for (const YamlValue& corner : list.items(3, 1000)) {
    occluder.corners.push_back(read_vector(corner));
  }
  const std::vector<Vector3d>& corners = occluder.corners;
  const std::size_t n = corners.size();
  Vector3d normal = Vector3d::Zero();  // its length is twice the area
  double size = 0;
  for (std::size_t i = 0; i < n; ++i) {
    normal += (corners[i] - corners[0]).cross(corners[(i + 1) % n] - corners[0]);
    size = std::max(size, (corners[i] - corners[0]).norm());
  }
  if (!(normal.norm() > 1e-9 * size * size)) list.fail_plainly("must not lie on a line");
  normal.normalize();
  double turned = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (std::abs((corners[i] - corners[0]).dot(normal)) > 1e-6 * size) {
      list.fail_plainly(fmt::format("must lie in a plane, but corner {} does not", i));
    }
    const Vector3d side = corners[(i + 1) % n] - corners[i];
    const Vector3d next = corners[(i + 2) % n] - corners[(i + 1) % n];
    const double turn = std::atan2(side.cross(next).dot(normal), side.dot(next));
    if (turn < -1e-6 || side.isZero()) {
      list.fail_plainly(fmt::format("must be convex, but is not at corner {}", (i + 1) % n));
    }
    turned += turn;
  }
  // A pentagram turns left at each corner too, but twice around.
  if (turned > 3 * std::numbers::pi) list.fail_plainly("must be convex, but its sides cross");
  return occluder;
}

RingPath read_ring(const YamlValue& value) {
  value.allow_only({"type", "centre_m", "radius_m", "start_deg", "end_deg", "target_m"});
  RingPath path;
  path.centre = vector_or_zero(value.find("centre_m"));
  path.radius_m = value.at("radius_m").positive();
  path.start_rad = degrees_or(value.find("start_deg"), 0, 3600);
  path.end_rad = degrees_or(value.find("end_deg"), 360, 3600);
  path.target = vector_or_zero(value.find("target_m"));
  return path;
}

void check_order(const YamlValue& value, double low, double high, const char* quantity) {
  if (low > high) {
    value.fail_plainly(fmt::format("min_{0}: must not be above max_{0}", quantity));
  }
}

DomePath read_dome(const YamlValue& value) {
  value.allow_only({"type", "target_m", "min_distance_m", "max_distance_m", "min_azimuth_deg",
                    "max_azimuth_deg", "min_elevation_deg", "max_elevation_deg"});
  DomePath path;
  path.target = vector_or_zero(value.find("target_m"));
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
  value.allow_only({"type", "from_m", "to_m", "target_m"});
  return {read_vector(value.at("from_m")), read_vector(value.at("to_m")),
          vector_or_zero(value.find("target_m"))};
}

ExplicitPath read_poses(const YamlValue& value) {
  value.allow_only({"type", "camera_from_world"});
  ExplicitPath path;
  for (const YamlValue& pose : value.at("camera_from_world").items(1, kMaxViews)) {
    path.camera_from_world.push_back(read_pose(pose));
  }
  return path;
}

CameraPath read_path(const YamlValue& value) {
  const YamlValue type = value.at("type");
  const std::string name = type.text();
  if (name == "ring") return read_ring(value);
  if (name == "dome") return read_dome(value);
  if (name == "line") return read_line(value);
  if (name == "poses") return read_poses(value);
  type.fail("must be ring, dome, line or poses");
}

PathJitter read_jitter(const YamlValue& value) {
  value.allow_only({"position_m", "target_m", "roll_deg"});
  PathJitter jitter;
  jitter.position_m = not_negative_or(value.find("position_m"), 0);
  jitter.target_m = not_negative_or(value.find("target_m"), 0);
  const auto roll = value.find("roll_deg");
  if (roll) jitter.roll_rad = radians(roll->number_in(0, 180));
  return jitter;
}

Sensor read_sensor(const YamlValue& value) {
  value.allow_only({"exposure", "blur_px", "noise_levels", "bits", "gamma"});
  Sensor sensor;
  const auto exposure = value.find("exposure");
  if (exposure) sensor.exposure = exposure->positive();
  const auto blur = value.find("blur_px");
  if (blur) sensor.blur_px = blur->number_in(0, 100);
  sensor.noise_levels = not_negative_or(value.find("noise_levels"), sensor.noise_levels);
  if (const auto bits = value.find("bits")) {
    const double count = bits->number();
    if (count != 8 && count != 16) bits->fail("must be 8 or 16");
    sensor.bits = static_cast<int>(count);
  }
  if (const auto gamma = value.find("gamma")) sensor.gamma = gamma->positive();
  return sensor;
}

double read_ink_spread(const YamlValue& value, double paper_margin_m) {
  const double spread = value.number();
  if (spread > paper_margin_m)
    value.fail(fmt::format("must not be above paper_margin_m, {}", paper_margin_m));
  return spread;
}

int read_num_views(const YamlValue& top, const CameraPath& path) {
  const auto views = top.find("views");
  const auto* poses = std::get_if<ExplicitPath>(&path);
  if (!poses) return top.at("views").whole(1, kMaxViews);
  const int num_poses = static_cast<int>(poses->camera_from_world.size());
  return views ? views->whole(1, num_poses) : num_poses;
}

std::vector<PlacedBoard> read_boards(const YamlValue& value, std::vector<std::string>* warnings) {
  std::vector<PlacedBoard> boards;
  for (const YamlValue& item : value.items(1, 10'000)) {
    std::vector<std::string> unknown;
    boards.push_back(read_placed_board(item, true, &unknown));
    // A target within the scene is not a file of Kalibr's: unknown keys are errors.
    if (!unknown.empty() && item.is_map() && item.find("target")) throw Error(unknown.front());
    if (warnings) warnings->insert(warnings->end(), unknown.begin(), unknown.end());
  }
  check_unique_ids(boards, value);
  return boards;
}

}  // namespace

Scene read_scene(const std::filesystem::path& file, std::vector<std::string>* warnings) {
  const YamlValue top = YamlValue::read(file);
  top.allow_only({"camera", "boards", "occluders", "path", "jitter", "views", "sensor",
                  "background_level", "paper_level", "ink_level", "ink_spread_m",
                  "paper_margin_m"});
  Scene scene = read_camera(top.at("camera"));
  scene.boards = read_boards(top.at("boards"), warnings);
  if (const auto occluders = top.find("occluders")) {
    for (const YamlValue& item : occluders->items(0, 10'000)) {
      scene.occluders.push_back(read_occluder(item));
    }
  }
  scene.path = read_path(top.at("path"));
  if (const auto jitter = top.find("jitter")) scene.jitter = read_jitter(*jitter);
  scene.num_views = read_num_views(top, scene.path);
  if (const auto sensor = top.find("sensor")) scene.sensor = read_sensor(*sensor);
  scene.background_level = level_or(top.find("background_level"), scene.background_level);
  scene.paper_level = level_or(top.find("paper_level"), scene.paper_level);
  scene.ink_level = level_or(top.find("ink_level"), scene.ink_level);
  scene.paper_margin_m = not_negative_or(top.find("paper_margin_m"), scene.paper_margin_m);
  if (const auto spread = top.find("ink_spread_m"))
    scene.ink_spread_m = read_ink_spread(*spread, scene.paper_margin_m);
  return scene;
}

}  // namespace tagcal
