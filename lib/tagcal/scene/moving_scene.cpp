#include "tagcal/scene/moving_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "tagcal/error.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;

Affine world_from(const Frames<Affine>& frames, const std::string& frame) {
  return frames.a_from_b(kWorldFrame, frame);
}

Pose rigid_world_from(const Frames<Affine>& frames, const std::string& frame,
                      std::string_view what) {
  if (frame == kWorldFrame) return {};
  try {
    return rigid(world_from(frames, frame));
  } catch (const Error&) {
    throw Error(fmt::format(
        "scene: {} hangs on frame '{}', which scales or shears, but must be rigid", what, frame));
  }
}

// Two poses count as the same if they differ by less than this: radians, and a share of 1 m plus
// the distance. Rounding in a chain of frames stays far below it, and a picture shows no smaller
// motion.
constexpr double kSamePlace = 1e-9;

bool same_place(const Pose& a, const Pose& b) {
  return angle_between_rad(a, b) < kSamePlace &&
         distance_between_m(a, b) <= kSamePlace * (1 + b.translation().norm());
}

// Finds the boards that stand still relative to the first one.
class StillBoards {
 public:
  explicit StillBoards(const Scene& first) : first_(first), still_(first.boards.size(), true) {}

  void add(const Scene& scene) {
    if (still_.empty()) return;
    const Pose world_from_first = scene.boards[0].world_from_board;
    first_moves_ |= !same_place(world_from_first, first_.boards[0].world_from_board);
    for (std::size_t b = 1; b < still_.size(); ++b)
      if (!same_place(
              world_from_first.inverse() * scene.boards[b].world_from_board,
              first_.boards[0].world_from_board.inverse() * first_.boards[b].world_from_board))
        still_[b] = false;
  }

  bool still(std::size_t board) const { return still_[board]; }

  // From the scene's world to the world of the data set.
  Pose dataset_from_world(const Scene& scene) const {
    if (!first_moves_) return {};
    return first_.boards[0].world_from_board * scene.boards[0].world_from_board.inverse();
  }

  std::vector<PlacedBoard> boards(std::vector<std::string>* warnings) const {
    std::vector<PlacedBoard> boards;
    for (std::size_t b = 0; b < still_.size(); ++b) {
      if (still_[b])
        boards.push_back(first_.boards[b]);
      else if (warnings)
        warnings->push_back(fmt::format(
            "boards[{}] moves relative to the first board: it is in the pictures and in "
            "truth.yaml, but not in dataset.yaml",
            b));
    }
    return boards;
  }

  // The ids of all points on these boards.
  std::set<CornerId> ids() const {
    std::set<CornerId> ids;
    for (std::size_t b = 0; b < still_.size(); ++b)
      if (still_[b])
        for (const TargetPoint& point : target_points(first_.boards[b].board)) ids.insert(point.id);
    return ids;
  }

 private:
  const Scene& first_;
  std::vector<bool> still_;
  bool first_moves_ = false;
};

HierarchyTruth hierarchy_truth(const Frames<Affine>& frames, const Scene& scene,
                               const Pose& camera_from_world) {
  HierarchyTruth truth;
  for (const std::string& name : frames.names())
    truth.camera_from_frame[name] = camera_from_world * world_from(frames, name);
  for (const PlacedBoard& placed : scene.boards)
    truth.camera_from_board.push_back(camera_from_world * placed.world_from_board);
  return truth;
}

void hang(const Affine& world_from_frame, Light& light) {
  if (auto* sun = std::get_if<DirectionalLamp>(&light.lamp))
    sun->direction = world_from_frame.linear() * sun->direction;
  if (auto* point = std::get_if<PointLamp>(&light.lamp))
    point->position = world_from_frame * point->position;
}

Frames<Affine> frames_at(const MovingScene& scene, double t) {
  std::vector<Frame<Affine>> frames;
  for (const MovingFrame& frame : scene.frames)
    frames.push_back({frame.name, frame.parent, frame.parent_from_frame(t)});
  return {kWorldFrame, frames};
}

Pose rigid_camera_frame_at(const MovingScene& scene, double t) {
  return rigid_world_from(frames_at(scene, t), scene.camera_frame, "the camera");
}

// The velocity along the path, by the difference of two poses beside the view; zero on a path
// that has no poses between its views.
CameraVelocity velocity_on_path(const MovingScene& scene, int view) {
  constexpr double kStep = 1e-3;  // numeric: of a view; its square is the error's share
  const int num_views = scene.settings.num_views;
  const double before = std::max(0.0, view - kStep),
               after = std::min(num_views - 1.0, view + kStep);
  const auto pose_at = [&](double place) {
    const std::optional<Pose> pose = pose_between_views(scene.settings, place);
    return *pose * rigid_camera_frame_at(scene, time_of_view(place, num_views)).inverse();
  };
  if (!(scene.period_s > 0) || !(after > before)) return {};
  if (!pose_between_views(scene.settings, view)) return {};
  const Vector6d twist =
      log_pose(pose_at(before) * pose_at(after).inverse()) / ((after - before) * scene.period_s);
  return {twist.head<3>(), twist.tail<3>()};
}

CameraVelocity velocity_in_view(const MovingScene& scene, int view) {
  CameraVelocity velocity = velocity_on_path(scene, view);
  if (!scene.velocity) return velocity;
  const CameraVelocity stated = scene.velocity(time_of_view(view, scene.settings.num_views));
  velocity.turn_rad_s += stated.turn_rad_s;
  velocity.move_m_s += stated.move_m_s;
  return velocity;
}

const FunctionPath* path_with_lens(const MovingScene& scene) {
  const auto* path = std::get_if<FunctionPath>(&scene.settings.path);
  return path && path->lens ? path : nullptr;
}

// Without the boards.
Dataset exact_dataset_of(const MovingScene& moving, const std::vector<Pose>& camera_from_world,
                         const StillBoards& boards) {
  const Scene first = scene_in_view(moving, 0);
  Dataset dataset{first.camera.image_size, {}, {}, {}};
  Truth truth{first.camera, first.model, {}, {}, {}};
  const std::set<CornerId> ids = boards.ids();
  for (int view = 0; view < static_cast<int>(camera_from_world.size()); ++view) {
    const Scene scene = moves(moving) ? scene_in_view(moving, view) : first;
    const Pose& pose = camera_from_world[static_cast<std::size_t>(view)];
    const std::string name = image_name(view);
    View seen{name, visible_corners(scene, pose)};
    std::erase_if(seen.observations, [&](const Observation& o) { return !ids.contains(o.id); });
    dataset.views.push_back(std::move(seen));
    truth.camera_from_world[name] = pose * boards.dataset_from_world(scene).inverse();
    if (!moving.frames.empty())
      truth.hierarchy[name] = hierarchy_truth(frames_in_view(moving, view), scene, pose);
    if (path_with_lens(moving)) truth.lenses.emplace(name, scene.camera.lens);
  }
  dataset.truth = std::move(truth);
  return dataset;
}

}  // namespace

bool moves(const MovingScene& scene) {
  return path_with_lens(scene) || scene.velocity || scene.period_s > 0 ||
         std::ranges::any_of(scene.frames, &MovingFrame::moves);
}

Frames<Affine> frames_in_view(const MovingScene& scene, int view) {
  return frames_at(scene, time_of_view(view, scene.settings.num_views));
}

Scene scene_in_view(const MovingScene& moving, int view) {
  const Frames<Affine> frames = frames_in_view(moving, view);
  Scene scene = moving.settings;
  for (std::size_t b = 0; b < moving.boards.size(); ++b) {
    const HungBoard& hung = moving.boards[b];
    const Pose frame = rigid_world_from(frames, hung.frame, fmt::format("boards[{}]", b));
    scene.boards.push_back({hung.board.board, hung.frame == kWorldFrame
                                                  ? hung.board.world_from_board
                                                  : frame * hung.board.world_from_board});
  }
  for (const HungOccluder& hung : moving.occluders) {
    scene.occluders.push_back(hung.occluder);
    if (hung.frame == kWorldFrame) continue;
    const Affine frame = world_from(frames, hung.frame);
    for (Vector3d& corner : scene.occluders.back().corners) corner = frame * corner;
  }
  if (scene.light && moving.light_frame != kWorldFrame)
    hang(world_from(frames, moving.light_frame), *scene.light);
  if (const FunctionPath* path = path_with_lens(moving))
    scene.camera.lens = path->lens(time_of_view(view, scene.num_views));
  scene.velocity = velocity_in_view(moving, view);
  return scene;
}

Pose rigid_camera_frame(const MovingScene& scene, int view) {
  return rigid_camera_frame_at(scene, time_of_view(view, scene.settings.num_views));
}

std::vector<Pose> camera_poses(const MovingScene& scene, std::uint64_t seed) {
  std::vector<Pose> poses = camera_poses(scene.settings, seed);
  if (scene.camera_frame == kWorldFrame) return poses;
  for (std::size_t i = 0; i < poses.size(); ++i)
    poses[i] = poses[i] * rigid_camera_frame(scene, static_cast<int>(i)).inverse();
  return poses;
}

Dataset exact_dataset(const MovingScene& scene, const std::vector<Pose>& camera_from_world,
                      std::vector<std::string>* warnings) {
  return std::move(exact_datasets({scene}, {camera_from_world}, warnings).front());
}

std::vector<Dataset> exact_datasets(const std::vector<MovingScene>& scenes,
                                    const std::vector<std::vector<Pose>>& camera_from_world,
                                    std::vector<std::string>* warnings) {
  const Scene first = scene_in_view(scenes.front(), 0);
  StillBoards boards(first);
  for (std::size_t c = 0; c < scenes.size(); ++c)
    for (std::size_t view = 0; moves(scenes[c]) && view < camera_from_world[c].size(); ++view)
      boards.add(scene_in_view(scenes[c], static_cast<int>(view)));
  std::vector<Dataset> datasets;
  for (std::size_t c = 0; c < scenes.size(); ++c)
    datasets.push_back(exact_dataset_of(scenes[c], camera_from_world[c], boards));
  const std::vector<PlacedBoard> placed = boards.boards(warnings);
  for (Dataset& dataset : datasets) dataset.boards = placed;
  return datasets;
}

std::vector<Occluder> cuboid(const Vector3d& size_m, double level) {
  if (!(size_m.minCoeff() > 0) || !size_m.allFinite())
    throw Error("cuboid: size_m: all sizes must be > 0");
  std::vector<Occluder> faces;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-0.5, 0.5}) {
      Occluder face{{}, level};
      // Counter-clockwise about the axis, so that the face looks to its side.
      for (const auto& [u, v] : {std::pair{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}) {
        Vector3d corner;
        corner[axis] = side;
        corner[(axis + 1) % 3] = side > 0 ? u : v;
        corner[(axis + 2) % 3] = side > 0 ? v : u;
        face.corners.push_back(corner.cwiseProduct(size_m));
      }
      faces.push_back(std::move(face));
    }
  return faces;
}

}  // namespace tagcal
