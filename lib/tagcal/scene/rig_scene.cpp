#include "tagcal/scene/rig_scene.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <variant>

#include "tagcal/random.hpp"

namespace tagcal {
namespace {

// The path of the rig at places between its views: 0 is the first view, num_views - 1 the last.
class RigPath {
 public:
  RigPath(const Scene& settings, std::uint64_t seed)
      : poses_(camera_poses(settings, seed)), last_(static_cast<double>(settings.num_views - 1)) {
    const PathJitter& jitter = settings.jitter;
    const bool is_exact =
        jitter.position_m == 0 && jitter.target_m == 0 && jitter.roll_rad == 0 && last_ > 0;
    const auto* path = std::get_if<FunctionPath>(&settings.path);
    if (path && is_exact) function_ = path->camera_from_world;
  }

  Pose at(double view) const {
    const double place = std::clamp(view, 0.0, last_);
    // A shift of whole periods must give the pose of a view itself, not one that is rounded.
    constexpr double kSameView = 1e-9;
    const double nearest = std::round(place);
    if (std::abs(place - nearest) < kSameView) return poses_[static_cast<std::size_t>(nearest)];
    if (function_) return function_(place / last_);
    const auto before = static_cast<std::size_t>(place);
    const Pose& pose = poses_[before];
    const double share = place - static_cast<double>(before);
    return pose * exp_pose(share * log_pose(pose.inverse() * poses_[before + 1]));
  }

 private:
  std::vector<Pose> poses_;
  double last_;
  std::function<Pose(double t)> function_;
};

double views_late(const RigScene& rig, std::size_t camera) {
  return rig.cameras[camera].time_offset_s / rig.period_s;
}

// Lets the frames be where they are `views` later, within the time of the scene.
void delay(MovingScene& scene, double views) {
  const int num_views = scene.settings.num_views;
  if (views == 0 || num_views < 2) return;
  const double share = views / (num_views - 1);
  for (MovingFrame& frame : scene.frames)
    frame.parent_from_frame = [at = std::move(frame.parent_from_frame), share](double t) {
      return at(std::clamp(t + share, 0.0, 1.0));
    };
}

// Gives the motion of a rig to the boards of the world, by the frame that they now hang on.
void move_boards(MovingScene& scene, const Pose& world_from_rig, std::vector<Pose> rig_from_world) {
  std::string name = "boards";
  while (std::ranges::find(scene.frames, name, &MovingFrame::name) != scene.frames.end())
    name += '_';
  for (HungBoard& board : scene.boards)
    if (board.frame == kWorldFrame) board.frame = name;
  const double last = static_cast<double>(rig_from_world.size() - 1);
  scene.frames.push_back({name, kWorldFrame,
                          [world_from_rig, last, poses = std::move(rig_from_world)](double t) {
                            return affine(world_from_rig *
                                          poses[static_cast<std::size_t>(std::lround(t * last))]);
                          },
                          true});
}

// The poses of the rig in the world at the instants of a scene, some views late.
std::vector<Pose> rig_poses(const MovingScene& delayed, const RigPath& path, double late) {
  std::vector<Pose> poses;
  for (int view = 0; view < delayed.settings.num_views; ++view)
    poses.push_back(path.at(view + late) * rigid_camera_frame(delayed, view).inverse());
  return poses;
}

}  // namespace

MovingScene scene_of_camera(const RigScene& rig, std::size_t index, std::uint64_t seed) {
  const RigSceneCamera& camera = rig.cameras[index];
  const RigPath path(rig.scene.settings, seed);
  MovingScene scene = rig.scene;
  Scene& settings = scene.settings;
  settings.camera = camera.camera;
  settings.model = camera.model;
  if (camera.sensor) settings.sensor = *camera.sensor;
  delay(scene, views_late(rig, index));
  std::vector<Pose> rig_from_world = rig_poses(scene, path, views_late(rig, index));
  if (rig.boards_move) {
    const Pose still = path.at(0) * rigid_camera_frame(rig.scene, 0).inverse();
    move_boards(scene, still.inverse(), rig_from_world);
    rig_from_world.assign(rig_from_world.size(), still);
  }
  const Pose camera_from_rig = camera.rig_from_camera.inverse();
  ExplicitPath explicit_path;
  for (const Pose& pose : rig_from_world)
    explicit_path.camera_from_world.push_back(camera_from_rig * pose);
  settings.path = std::move(explicit_path);
  settings.jitter = {};
  scene.camera_frame = kWorldFrame;
  return scene;
}

std::uint64_t camera_seed(std::uint64_t seed, std::size_t camera) {
  constexpr std::uint64_t kBeyondViews = std::uint64_t{1} << 32;  // streams that no view has
  return camera == 0 ? seed : Random(seed, kBeyondViews + camera).next();
}

RigDataset exact_rig_dataset(const RigScene& rig, std::uint64_t seed,
                             std::vector<std::string>* warnings) {
  std::vector<MovingScene> scenes;
  std::vector<std::vector<Pose>> poses;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    scenes.push_back(scene_of_camera(rig, c, seed));
    poses.push_back(camera_poses(scenes.back(), seed));
  }
  std::vector<Dataset> datasets = exact_datasets(scenes, poses, warnings);
  RigDataset result;
  RigTruth truth;
  const auto num_instants = static_cast<std::size_t>(rig.scene.settings.num_views);
  std::vector<double> times_s;
  for (std::size_t i = 0; i < num_instants; ++i)
    times_s.push_back(static_cast<double>(i) * rig.period_s);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    result.cameras.push_back({rig.cameras[c].name, std::move(datasets[c]), times_s});
    truth.camera_from_rig.push_back(rig.cameras[c].rig_from_camera.inverse());
    truth.time_offset_s.push_back(rig.cameras[c].time_offset_s);
  }
  for (std::size_t i = 0; i < num_instants; ++i)
    result.instants.push_back({std::vector<std::optional<std::size_t>>(rig.cameras.size(), i)});
  result.truth = std::move(truth);
  return result;
}

}  // namespace tagcal
