#pragma once

#include <vector>

#include "study/tasks/pose_task.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/random.hpp"

// Random views for studies of poses: f = 900 px, 1280 x 800 px.

namespace tagcal::study {

using internal::kDegree;
inline constexpr double kStudyFocalPx = 900;

Camera study_camera();

// Corners of a square about the origin, z to the viewer, in the order of IPPE_SQUARE: upper left,
// upper right, lower right, lower left.
std::vector<Eigen::Vector3d> square_points(double side_m);

// The corners of a board of n x n tags (spacing 0.3 of a tag), about 0.66 m wide and centred at the
// origin, and the tag of each corner.
std::vector<Eigen::Vector3d> tag_grid_points(int n);
std::vector<int> tag_grid_groups(int n);

// Random points in a cube about the origin.
std::vector<Eigen::Vector3d> space_points(std::size_t n, double side_m, Random& random);

// A random subset of 0 .. n - 1 with `how_many` elements, ascending.
std::vector<std::size_t> some_of(std::size_t n, std::size_t how_many, Random& random);

struct ViewRange {
  double min_tilt_deg = 0, max_tilt_deg = 52;
  double min_distance_m = 0.7, max_distance_m = 1.6;
  double sigma_px = 0.5;
  double wrong = 0;   // share of the corners with a random pixel
  bool aside = true;  // off the optical axis; on it, the tilt is also that to the image plane
};

// A view, from a random side, of points about the origin of their frame.
PoseTask draw_task(const std::vector<Eigen::Vector3d>& points, const ViewRange& range,
                   Random& random);

}  // namespace tagcal::study
