#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/scene/scene.hpp"
#include "tagcal/viewing/canonical.hpp"

// The steps of the viewing pipeline of one camera of a scene: object -> world -> camera -> eye ->
// clip -> normalised device -> raster, and the coordinates of a point in each
// (docs/course/viewing.md).

namespace tagcal {

// A point to follow: in the frame of a board, or in the world frame if it has no board.
struct NamedPoint {
  std::string name;
  std::optional<std::size_t> board;  // index in the scene
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::optional<CornerId> corner;  // set if it can be observed
};

// A corner of the scene by its id. No value if the scene has no such corner.
std::optional<NamedPoint> named_corner(const Scene& scene, const CornerId& id);

// The matrices of one camera. A matrix cannot represent distortion: those from the eye on belong to
// the camera without it (undistorted() in viewing/viewport.hpp), which any renderer can draw. An
// oblique projection is the orthographic one of a sheared space.
struct ViewingPipeline {
  Camera camera;
  Pose camera_from_world;
  Eigen::Matrix4d eye_from_camera;  // OpenCV's axes to OpenGL's; of an oblique lens after a shear
  ViewVolume volume;
  Eigen::Matrix4d clip_from_eye;
  Eigen::Matrix4d raster_from_ndc;
};

// Throws Error for planes that enclose no volume (near < far; near > 0 for a perspective).
ViewingPipeline viewing_pipeline(const Camera& camera, const Pose& camera_from_world, double near_m,
                                 double far_m);

// Near and far planes that enclose all boards and occluders in front of the camera: half the least
// depth and twice the greatest; 0.1 m and 100 m if nothing is in front.
struct NearFar {
  double near_m = 0;
  double far_m = 0;
};
NearFar enclosing_planes(const Scene& scene, const Pose& camera_from_world);

// Where a camera sees a point, and its pose at that instant.
struct Sighting {
  Eigen::Vector2d pixel;
  Pose camera_from_world;
};

// The sighting of a point of the world: with a rolling shutter, at the pose of the line on which it
// is seen, by fixed-point iteration (it converges unless the point runs with the readout, which has
// no value). No value outside the lens' domain.
std::optional<Sighting> sighting(const Scene& scene, const Pose& camera_from_world,
                                 const Eigen::Vector3d& x_in_world);

// The exact pixels of the corners that a view shows, ordered by id: those in the lens' domain and
// inside the image, on a face turned to the camera, and hidden neither by an occluder nor by the
// paper of another board. Points of a `points` target have no face and are visible from both sides;
// the markers of a ChArUco board are not observed.
std::vector<Observation> visible_corners(const Scene& scene, const Pose& camera_from_world);

// Reason why a point is not seen.
enum class Sight {
  seen,
  outside_domain,  // behind the camera or beyond what its lens projects: no pixel
  outside_image,
  turned_away,  // on the back of its board
  hidden,       // behind a board or an occluder
};
std::string_view sight_text(Sight sight);

// The coordinates of a point in each frame; no value after the step at which it has no image.
struct FollowedPoint {
  std::optional<Eigen::Vector3d> in_board;
  Eigen::Vector3d in_world;
  Eigen::Vector3d in_camera;
  Eigen::Vector3d in_eye;
  Eigen::Vector4d in_clip;
  bool in_volume = false;                       // -w <= x, y, z <= w
  std::optional<Eigen::Vector3d> in_ndc;        // after the division by w
  std::optional<Eigen::Vector2d> in_raster_px;  // without distortion
  std::optional<Eigen::Vector2d> pixel;         // through the lens
  Sight sight = Sight::seen;
  std::string hidden_by;  // "board 0", "occluder 2": counted from 0 in the scene; empty: nothing
  std::optional<Eigen::Vector3d> hit_in_world;  // what hides it, where the line of sight meets it
};

FollowedPoint followed(const NamedPoint& point, const Scene& scene,
                       const ViewingPipeline& pipeline);

}  // namespace tagcal
