#pragma once

#include <Eigen/Core>
#include <variant>

#include "tagcal/camera/camera.hpp"
#include "tagcal/scene/image.hpp"

// What reprojection works with: the picture of a camera, and the new picture (the target), which is
// that of another camera, a panorama, or a plane of the scene seen from above.

namespace tagcal {

enum class PanoramaKind {
  equirectangular,  // rows are latitudes: v = centre.y + px_per_rad * latitude
  cylindrical,      // upright lines stay straight: v = centre.y + px_per_rad * tan(latitude)
  transverse,       // equirectangular about the horizontal axis (x): see below
};

// A picture of all directions about the vertical axis (y) of its frame, which has the axes of a
// camera: x right, y down, z forward. Column u is longitude (u - centre.x) / px_per_rad, positive
// to the right of z; latitudes are positive downwards. Longitudes beyond pi either way, and
// latitudes beyond pi / 2, have no ray. In a transverse one columns and rows change places: row v
// is the angle (v - centre.y) / px_per_rad about the axis x, positive from z downwards, and column
// u is centre.x + px_per_rad times the latitude, positive to the right. The epipolar lines of two
// cameras whose baseline is along x are its rows.
struct Panorama {
  PanoramaKind kind = PanoramaKind::equirectangular;
  double px_per_rad = 100;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  ImageSize size;
};

// A rectangle of the plane z = 0 of a frame (that of a board: x right, y up, z towards the viewer),
// seen from the side of +z. Pixel (u, v) is the point upper_left + (u, -v) * m_per_px.
struct PlaneRaster {
  Eigen::Vector2d upper_left = Eigen::Vector2d::Zero();  // centre of pixel (0, 0), metres
  double m_per_px = 0.001;                               // > 0
  ImageSize size;
};

// A camera of a target must have rays from one centre: no parallel lens.
using Target = std::variant<Camera, Panorama, PlaneRaster>;

inline ImageSize size_of(const Target& target) {
  if (const auto* camera = std::get_if<Camera>(&target)) return camera->image_size;
  if (const auto* panorama = std::get_if<Panorama>(&target)) return panorama->size;
  return std::get<PlaneRaster>(target).size;
}

// A camera and a target beside it. Of camera_from_target only the rotation is used for targets that
// show directions (the scene is far away, or the target camera is at the same place); for a plane
// it is the pose of the plane's frame.
struct Reprojection {
  Camera camera;
  Target target;
  Pose camera_from_target;
};

// For each pixel of a target, the pixel of the source: the pair of float32 images that cv::remap
// takes. (kNoSource, kNoSource) where there is none: cv::remap then writes its border value, as for
// all coordinates outside the picture.
struct PixelMap {
  ImageF x;
  ImageF y;
};
inline constexpr float kNoSource = -1;

}  // namespace tagcal
