#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/scene/scene.hpp"
#include "tagcal/viewing/canonical.hpp"

// The viewing pipeline of one camera of a scene, laid open: object -> world -> camera -> eye ->
// clip -> normalised device -> raster, and a point followed through all of it (docs/viewing.md).

namespace tagcal {

// A point to follow: of a board, in the board's frame, or one of the world alone.
struct NamedPoint {
  std::string name;
  std::optional<std::size_t> board;  // index in the scene
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::optional<CornerId> corner;  // where it can be observed
};

// A corner of the scene by its name. No value where the scene has none of that name.
std::optional<NamedPoint> named_corner(const Scene& scene, const CornerId& id);

// The matrices of one camera. A matrix holds no distortion: from the eye on they are those of the
// camera without it (undistorted() in viewing/viewport.hpp), which any renderer can draw.
struct ViewingPipeline {
  Camera camera;
  Pose camera_from_world;
  Eigen::Matrix4d eye_from_camera;  // OpenCV's axes to OpenGL's
  ViewVolume volume;
  Eigen::Matrix4d clip_from_eye;
  Eigen::Matrix4d raster_from_ndc;
};

// Throws Error for planes that enclose no volume (near < far; near > 0 for a perspective).
ViewingPipeline viewing_pipeline(const Camera& camera, const Pose& camera_from_world, double near_m,
                                 double far_m);

// Planes that enclose all boards and occluders which lie in front of the camera, with room: half
// the least depth and twice the greatest; 0.1 m and 100 m where nothing is in front.
struct NearFar {
  double near_m = 0;
  double far_m = 0;
};
NearFar enclosing_planes(const Scene& scene, const Pose& camera_from_world);

// Where the corners of the scene are in a view, exactly: those in front of the camera and in its
// lens' domain, inside the image, on a face turned to the camera, and hidden neither by an occluder
// nor by the paper of another board. Points of a `points` target have no face and are seen from
// everywhere. Ordered by id.
std::vector<Observation> visible_corners(const Scene& scene, const Pose& camera_from_world);

// What became of the point.
enum class Sight {
  seen,
  outside_domain,  // behind the camera or beyond what its lens projects: no pixel
  outside_image,
  turned_away,  // on the back of its board
  hidden,       // behind a board or an occluder
};
std::string_view sight_text(Sight sight);

// The coordinates of a point in each frame; no value from where it has no image.
struct FollowedPoint {
  std::optional<Eigen::Vector3d> in_board;
  Eigen::Vector3d in_world;
  Eigen::Vector3d in_camera;
  Eigen::Vector3d in_eye;
  Eigen::Vector4d in_clip;
  bool in_volume = false;                       // -w <= x, y, z <= w
  std::optional<Eigen::Vector3d> in_ndc;        // after the divide
  std::optional<Eigen::Vector2d> in_raster_px;  // without distortion
  std::optional<Eigen::Vector2d> pixel;         // through the lens
  Sight sight = Sight::seen;
};

FollowedPoint followed(const NamedPoint& point, const Scene& scene,
                       const ViewingPipeline& pipeline);

}  // namespace tagcal
