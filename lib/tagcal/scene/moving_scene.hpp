#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tagcal/geometry/transform.hpp"
#include "tagcal/scene/scene.hpp"
#include "tagcal/viewing/frames.hpp"

// A scene whose parts hang on a hierarchy of frames, which may move from view to view.

namespace tagcal {

constexpr const char* kWorldFrame = "world";  // the root of the hierarchy

// A frame at time t, which runs evenly over the views: 0 at the first, 1 at the last.
struct MovingFrame {
  std::string name;
  std::string parent = kWorldFrame;
  std::function<Affine(double t)> parent_from_frame;
  bool moves = false;  // false: the transform is the same at any time
};

// A board in the coordinates of its frame, which must be rigid relative to the world.
struct HungBoard {
  std::string frame = kWorldFrame;
  PlacedBoard board;
};

// An occluder in the coordinates of its frame, which may scale and shear.
struct HungOccluder {
  std::string frame = kWorldFrame;
  Occluder occluder;
};

struct MovingScene {
  Scene settings;  // of the scene at any time; without boards and occluders
  std::vector<MovingFrame> frames;
  std::vector<HungBoard> boards;
  std::vector<HungOccluder> occluders;
  std::string camera_frame = kWorldFrame;  // of the camera's path; rigid relative to the world
  std::string light_frame = kWorldFrame;   // of the lamp in the settings
  // Seconds between views, for a rolling shutter: the camera moves along its path while a picture
  // is read (pose_between_views). 0: it does not, and neither does one whose path has no poses
  // between its views.
  double period_s = 0;
  std::function<CameraVelocity(double t)> velocity;  // empty, or added to that along the path
};

// Returns true if boards, occluders, the lens or the velocity differ from view to view.
bool moves(const MovingScene& scene);

// The hierarchy in one view. Throws Error for names that are empty, unknown or used twice, for a
// frame that would be its own ancestor, and for a transform that is not finite.
Frames<Affine> frames_in_view(const MovingScene& scene, int view);

// The scene as it stands in one view, in world coordinates, with the camera and the velocity of
// that view. Throws Error as frames_in_view, and if a board hangs on a frame that is not rigid.
Scene scene_in_view(const MovingScene& scene, int view);

// The pose in the world of the frame in which the camera's path is given. Throws Error as
// frames_in_view, and if it is not rigid.
Pose rigid_camera_frame(const MovingScene& scene, int view);

// The poses of all views. Equal seeds give equal poses. Throws Error as rigid_camera_frame and
// as camera_poses of a Scene.
std::vector<Pose> camera_poses(const MovingScene& scene, std::uint64_t seed);

// The data set of a scene: the boards that stand still relative to the first one, their exact
// corners and the truth. Its world is that of the scene as long as the first board stands still,
// and moves with it otherwise. Boards that move relative to the first one are left out, and
// `warnings` (may be null) names them.
Dataset exact_dataset(const MovingScene& scene, const std::vector<Pose>& camera_from_world,
                      std::vector<std::string>* warnings);

// The data sets of several cameras in one scene, whose scenes differ in the camera and its times
// only. Boards and world are common: those of exact_dataset for the first camera, without boards
// that move relative to the first board for any camera. `camera_from_world`: by camera and view.
std::vector<Dataset> exact_datasets(const std::vector<MovingScene>& scenes,
                                    const std::vector<std::vector<Pose>>& camera_from_world,
                                    std::vector<std::string>* warnings);

// A box as six faces: its centre is the origin, its sides are along the axes. All sizes > 0, else
// Error.
std::vector<Occluder> cuboid(const Eigen::Vector3d& size_m, double level);

}  // namespace tagcal
