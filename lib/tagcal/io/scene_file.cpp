#include "tagcal/io/scene_file.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <limits>
#include <numbers>

#include "tagcal/error.hpp"
#include "tagcal/io/scene/scene_parts.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/yaml/yaml_boards.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"
#include "tagcal/scene/visibility/polygon.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector3d;

Occluder read_occluder(const YamlValue& value) {
  value.allow_only({"corners", "level", "frame"});
  Occluder occluder;
  occluder.level = level_or(value.find("level"), occluder.level);
  const YamlValue list = value.at("corners");
  for (const YamlValue& corner : list.items(3, kMaxPolygonCorners)) {
    occluder.corners.push_back(read_vector(corner));
  }
  if (const auto wrong = why_no_polygon(occluder.corners)) list.fail_plainly(*wrong);
  return occluder;
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

double read_ink_spread(const YamlValue& value, double paper_margin_m) {
  const double spread = value.number();
  if (spread > paper_margin_m)
    value.fail(fmt::format("must not be above paper_margin_m, {}", paper_margin_m));
  return spread;
}

PlacedBoard read_board(const YamlValue& value, TargetFiles& targets,
                       std::vector<std::string>* warnings) {
  std::vector<std::string> unknown;
  PlacedBoard board = read_placed_board(value, true, targets, &unknown);
  // A target within the scene is not a file of Kalibr's: unknown keys are errors.
  if (!unknown.empty() && value.is_map() && value.find("target")) throw Error(unknown.front());
  if (warnings) warnings->insert(warnings->end(), unknown.begin(), unknown.end());
  if (!value.is_map()) return board;
  const auto pose = value.find("pose"), in_world = value.find("world_from_board");
  if (in_world && (pose || value.find("frame")))
    in_world->fail_plainly("belongs to a board without frame and pose");
  if (pose) board.world_from_board = read_rigid_placement(*pose);
  return board;
}

void read_boards(const YamlValue& value, MovingScene& scene, std::vector<std::string>* warnings) {
  std::vector<PlacedBoard> boards;
  TargetFiles targets;
  std::size_t num_parts = 0;
  for (const YamlValue& item : value.items(1, limits::kMaxBoards)) {
    boards.push_back(read_board(item, targets, warnings));
    count_parts(boards.back().board, value, num_parts);
    const bool is_map = item.is_map();
    scene.boards.push_back(
        {is_map ? read_frame_of(item, scene.frames) : kWorldFrame, boards.back()});
  }
  check_unique_ids(boards, value);
}

void read_cuboid(const YamlValue& value, const std::string& name, MovingScene& scene) {
  value.allow_only({"size_m", "level", "frame", "pose"});
  const YamlValue size = value.at("size_m");
  for (const YamlValue& side : size.items(3, 3)) side.positive();
  const std::string frame = read_frame_of(value, scene.frames);
  Affine frame_from_cuboid = Affine::Identity();
  if (const auto pose = value.find("pose")) frame_from_cuboid = read_placement(*pose);
  for (Occluder& face :
       cuboid(read_vector(size), level_or(value.find("level"), Occluder().level))) {
    for (Vector3d& corner : face.corners) corner = frame_from_cuboid * corner;
    face.name = name;
    scene.occluders.push_back({frame, std::move(face)});
  }
}

void read_surfaces(const YamlValue& top, MovingScene& scene) {
  if (const auto occluders = top.find("occluders"))
    for (const YamlValue& item : occluders->items(0, limits::kMaxSheets)) {
      Occluder occluder = read_occluder(item);
      scene.occluders.push_back({read_frame_of(item, scene.frames), std::move(occluder)});
    }
  int num_cuboids = 0;
  if (const auto cuboids = top.find("cuboids"))
    for (const YamlValue& item : cuboids->items(0, limits::kMaxSheets))
      read_cuboid(item, fmt::format("cuboid {}", num_cuboids++), scene);
}

// The path of the camera, or of the rig's frame.
void read_views(const YamlValue& top, bool behind_window, MovingScene& moving) {
  Scene& scene = moving.settings;
  const YamlValue path = top.at("path");
  scene.path = read_path(path, scene.camera.image_size);
  moving.camera_frame = read_frame_of(path, moving.frames);
  scene.num_views = read_num_views(top, scene.path);
  const bool window = path.at("type").text() == "window";
  if (window != behind_window)
    path.fail_plainly("type window and the camera's model window need each other");
  if (const auto jitter = top.find("jitter")) {
    if (window) jitter->fail_plainly("does not go with a window");
    scene.jitter = read_jitter(*jitter);
  }
}

// The motion of the camera while a picture is read.
void read_velocity(const YamlValue& top, MovingScene& scene) {
  const auto period = top.find("period_ms"), velocity = top.find("velocity");
  if (period) {
    if (!pose_between_views(scene.settings, 0))
      period->fail_plainly(
          "needs a path with one view after another, not dome or poses: state the "
          "velocity");
    period->positive();
    scene.period_s = period->number_in(0, kMostMilliseconds) * 1e-3;
  }
  if (!velocity) return;
  velocity->allow_only({"turn_deg_s", "move_m_s"});
  const auto of = [&](const char* key) {
    const auto value = velocity->find(key);
    return value ? vectors_over_views(*value) : VectorOverViews({Vector3d::Zero()});
  };
  scene.velocity = [turn = of("turn_deg_s"), move = of("move_m_s")](double t) {
    return CameraVelocity{radians(1) * turn.at(t), move.at(t)};
  };
}

void read_levels(const YamlValue& top, Scene& scene) {
  scene.background_level = level_or(top.find("background_level"), scene.background_level);
  scene.paper_level = level_or(top.find("paper_level"), scene.paper_level);
  scene.ink_level = level_or(top.find("ink_level"), scene.ink_level);
  scene.paper_margin_m = not_negative_or(top.find("paper_margin_m"), scene.paper_margin_m);
  if (const auto spread = top.find("ink_spread_m"))
    scene.ink_spread_m = read_ink_spread(*spread, scene.paper_margin_m);
  scene.print_grid_m = not_negative_or(top.find("print_grid_m"), 0);
}

// Throws, with the file's name, if a part or the camera hangs on a frame that is not rigid.
void check_first_view(const YamlValue& top, const MovingScene& scene) {
  top.within([&] {
    scene_in_view(scene, 0);
    rigid_camera_frame(scene, 0);
  });
}

void read_all_but_cameras(const YamlValue& top, bool behind_window, MovingScene& scene,
                          std::vector<std::string>* warnings) {
  scene.frames = read_frames(top);
  read_boards(top.at("boards"), scene, warnings);
  read_surfaces(top, scene);
  read_views(top, behind_window, scene);
  read_velocity(top, scene);
  read_levels(top, scene.settings);
  if (const auto light = top.find("light")) {
    scene.settings.light = read_light(*light);
    scene.light_frame = read_frame_of(*light, scene.frames);
  }
  check_first_view(top, scene);
}

}  // namespace

AnyScene read_any_scene(const std::filesystem::path& file, std::vector<std::string>* warnings) {
  const YamlValue top = YamlValue::read(file);
  if (!top.find("path")) top.refuse_other_kind("a scene");
  top.allow_only({"camera",           "rig",
                  "frames",           "motion",
                  "boards",           "occluders",
                  "cuboids",          "path",
                  "jitter",           "views",
                  "sensor",           "light",
                  "background_level", "paper_level",
                  "ink_level",        "ink_spread_m",
                  "print_grid_m",     "paper_margin_m",
                  "period_ms",        "velocity"});
  if (!top.find("rig")) {
    const SceneCamera camera = read_camera(top.at("camera"));
    MovingScene scene;
    scene.settings.camera = camera.camera;
    scene.settings.model = camera.model;
    if (const auto sensor = top.find("sensor"))
      scene.settings.sensor = read_sensor(*sensor, camera.camera);
    read_all_but_cameras(top, camera.behind_window, scene, warnings);
    return scene;
  }
  for (const char* key : {"period_ms", "velocity"})
    if (const auto moving = top.find(key))
      moving->fail_plainly("belongs to a scene with one camera, and a rolling shutter");
  RigScene rig;
  read_rig(top, rig);
  rig.scene.settings.camera = rig.cameras.front().camera;
  read_all_but_cameras(top, false, rig.scene, warnings);
  return rig;
}

MovingScene read_moving_scene(const std::filesystem::path& file,
                              std::vector<std::string>* warnings) {
  AnyScene scene = read_any_scene(file, warnings);
  if (auto* moving = std::get_if<MovingScene>(&scene)) return std::move(*moving);
  throw Error(file.string() + ": rig: only tagcal render draws a rig: give the scene one camera");
}

Scene read_scene(const std::filesystem::path& file, std::vector<std::string>* warnings) {
  const MovingScene scene = read_moving_scene(file, warnings);
  if (moves(scene) || scene.camera_frame != kWorldFrame)
    throw Error(file.string() + ": motion: must be empty, and the path's frame world, here");
  return scene_in_view(scene, 0);
}

SceneLimits scene_limits() {
  return {limits::kMaxViews, limits::kMaxVignettingTerms, limits::kMaxPixels, kMaxPolygonCorners};
}

std::optional<std::string> occluder_defect(std::span<const Eigen::Vector3d> corners) {
  return why_no_polygon(corners);
}

}  // namespace tagcal
