#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

// A view and the poses found in it.
struct PoseDrawing {
  Camera camera;
  Eigen::AlignedBox3d target;                          // that holds its points, target frame
  std::vector<Correspondence> corners;                 // as observed
  std::vector<std::size_t> outliers;                   // of the corners
  std::vector<Pose> camera_from_target;                // best first
  std::vector<std::vector<Eigen::Vector3d>> outlines;  // of the tags, where there is no picture
};

// The picture, or white where there is none (empty), with the target's axes (x red, y green, z
// blue, half as long as the target) and a box on the target, half as high as it is long, towards
// the camera; a second pose thin and dashed. Observed corners are rings, where they should be
// crosses; outliers are crossed out and tied to their place. All lines go through the lens.
ImageRgb draw_pose(const PoseDrawing& drawing, const Image8& picture);

}  // namespace tagcal::tools
