#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/geometry/pose.hpp"
#include "tagcal/scene/moving_scene.hpp"
#include "tagcal/scene/rig.hpp"

// A scene that is seen by several cameras on one rigid body.

namespace tagcal {

struct RigSceneCamera {
  std::string name;
  Camera camera;
  std::string model;  // the smallest candidate model that contains the camera
  Pose rig_from_camera;
  // Its pictures are taken that much later than the instants of the rig, whose times they carry.
  double time_offset_s = 0;
  std::optional<Sensor> sensor = {};  // no value: that of the scene
};

struct RigScene {
  // The path is that of the rig's frame: rig_from_world takes the place of camera_from_world. The
  // camera and the model in its settings are not used. The path must not change the lens.
  MovingScene scene;
  std::vector<RigSceneCamera> cameras;
  // False: the rig moves along the path. True: the rig stands at the first pose of the path, and
  // the boards that hang on the world move so that the rig sees them as from the path; all else
  // stays where it is.
  bool boards_move = false;
  double period_s = 0.05;  // between instants, > 0
};

// What one camera of the rig sees, with its poses at all instants as an ExplicitPath. Between the
// instants a path that is a function of time is evaluated, unless it has jitter; the poses of
// others are interpolated along the screw motion from one to the next. Before the first and after
// the last instant the rig stands still. A time offset of whole periods gives the poses of other
// instants to the last bit. The seed is that of the path's jitter. Throws Error as camera_poses.
MovingScene scene_of_camera(const RigScene& rig, std::size_t camera, std::uint64_t seed);

// The seed of a camera's `noise_seed`: cameras have independent noise. That of camera 0 is `seed`.
std::uint64_t camera_seed(std::uint64_t seed, std::size_t camera);

// The exact corners of all cameras, with the times of the instants and the truth. The boards and
// their world are common to the cameras, as in exact_dataset. Throws Error as scene_of_camera.
RigDataset exact_rig_dataset(const RigScene& rig, std::uint64_t seed,
                             std::vector<std::string>* warnings);

}  // namespace tagcal
