#pragma once

#include "study/atlas/stability.hpp"
#include "study/atlas/stability_judge.hpp"
#include "study/tasks/pose_tasks.hpp"

// Maps of failure of poses. Private to study.

namespace tagcal::study {

struct MapMethod {
  PoseMethod method;
  bool drawn = false;
};

// Our methods, with and without stated noise.
MapMethod our_pose();
MapMethod our_pose_of_unknown_noise();
MapMethod our_pose_and_focal();
MapMethod our_pose_and_focal_of_unknown_noise();
MapMethod peer(const PoseMethod& method);   // in the picture
MapMethod aside(const PoseMethod& method);  // in the table only

// Sets the methods and the problems of the map.
void ask_pose(
    StabilityMap& map, const std::vector<MapMethod>& methods,
    const std::function<PoseQuestion(std::span<const double> at, Random& random)>& question);

// The indices of all correspondences of a task.
std::vector<std::size_t> all_of(const PoseTask& task);

// A question with only correct points.
PoseQuestion all_right(PoseTask task);

// Adds the noisy images of points to a task. Points behind the camera are seen mirrored, at x / z.
// Precondition: no point is in the plane z = 0 of the camera.
void see(const std::vector<Eigen::Vector3d>& points, PoseTask& task, Random& random);

// Returns true if `right` of n corners agree on a pose better than corners at random pixels do by
// chance (a contrario: the expected number of such agreements is below 1e-4).
bool beyond_chance(std::size_t n, std::size_t right, double sigma_px);

StabilityMap tag_tilt_distance_map();
StabilityMap turns_map();
StabilityMap flatness_map();
StabilityMap line_map();
StabilityMap points_map();
StabilityMap near_camera_map();
StabilityMap behind_camera_map();
StabilityMap wrong_corners_map();
StabilityMap swapped_map();
StabilityMap bad_data_map();
StabilityMap units_map();
StabilityMap focal_tilt_map();
StabilityMap focal_distance_map();

std::vector<StabilityMap> pose_maps();

}  // namespace tagcal::study
