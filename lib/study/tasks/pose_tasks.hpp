#pragma once

#include <numbers>
#include <vector>

#include "study/tasks/pose_task.hpp"
#include "tagcal/random.hpp"

// The views that studies of pose solve: f = 900 px, 1280 x 800, drawn by seeds.

namespace tagcal::study {

inline constexpr double kDegree = std::numbers::pi / 180;
inline constexpr double kStudyFocalPx = 900;

Camera study_camera();

// In the order that IPPE_SQUARE asks for: upper left, upper right, lower right, lower left; about
// the origin, z to the viewer.
std::vector<Eigen::Vector3d> square_points(double side_m);

// The corners of a board of n x n tags (spacing 0.3 of a tag) that is about 0.66 m wide, about its
// centre, and the tag of each.
std::vector<Eigen::Vector3d> tag_grid_points(int n);
std::vector<int> tag_grid_groups(int n);

// In a cube about the origin.
std::vector<Eigen::Vector3d> space_points(std::size_t n, double side_m, Random& random);

struct ViewRange {
  double min_tilt_deg = 0, max_tilt_deg = 52;
  double min_distance_m = 0.7, max_distance_m = 1.6;
  double sigma_px = 0.5;
  double wrong = 0;   // share of the corners that are anywhere in the image
  bool aside = true;  // off the optical axis; else the tilt is that to the image as well
};

// A view of points about the origin of their frame, from a random side.
PoseTask draw_task(const std::vector<Eigen::Vector3d>& points, const ViewRange& range,
                   Random& random);

}  // namespace tagcal::study
