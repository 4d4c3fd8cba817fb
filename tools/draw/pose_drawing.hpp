#pragma once

#include <Eigen/Geometry>
#include <map>
#include <string>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/scene/dataset.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

// A view and the poses found in it.
struct PoseDrawing {
  Camera camera;
  Eigen::AlignedBox3d target;                          // of its points, target frame
  std::vector<Correspondence> corners;                 // as observed
  std::vector<std::size_t> outliers;                   // of the corners
  std::vector<Pose> camera_from_target;                // best first
  std::vector<std::vector<Eigen::Vector3d>> outlines;  // of the tags, if there is no picture
};

// Sets the box about the points of a target, and the outlines of its tags.
void set_target(const std::map<CornerId, Eigen::Vector3d>& points, PoseDrawing& drawing);

// Unique file names for the drawings, made from the names of the pictures. Their ending differs, so
// that no drawing overwrites its picture.
std::vector<std::string> drawing_names(const std::vector<View>& views);

// Returns the picture, or white if it is empty, with the target's axes (x red, y green, z blue,
// half as long as the target) and a box on the target towards the camera, half as high as it is
// long; a second pose is thin and dashed. Rings are observed corners, crosses projected ones;
// outliers are crossed out and connected with their projection. All lines are projected by the
// lens.
ImageRgb draw_pose(const PoseDrawing& drawing, const Image8& picture);

}  // namespace tagcal::tools
