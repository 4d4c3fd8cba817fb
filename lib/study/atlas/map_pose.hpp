#pragma once

#include "study/atlas/stability.hpp"
#include "study/atlas/stability_judge.hpp"

// Maps of failure of poses. Private to study.

namespace tagcal::study {

struct MapMethod {
  PoseMethod method;
  bool drawn = false;
};

// Ours, and ours that is not told the noise.
MapMethod our_pose();
MapMethod our_pose_of_unknown_noise();
MapMethod our_pose_and_focal();
MapMethod our_pose_and_focal_of_unknown_noise();
MapMethod peer(const PoseMethod& method);   // in the picture
MapMethod aside(const PoseMethod& method);  // in the table only

// Gives the map its methods, and its problems.
void ask_pose(
    StabilityMap& map, const std::vector<MapMethod>& methods,
    const std::function<PoseQuestion(std::span<const double> at, Random& random)>& question);

// All correspondences of a task, as those that are right.
std::vector<std::size_t> all_of(const PoseTask& task);

// A question whose points are all right.
PoseQuestion all_right(PoseTask task);

// What the camera of a task sees of points, with its noise. Precondition: they are not in its
// plane; those behind are seen mirrored, as x / z has them.
void see(const std::vector<Eigen::Vector3d>& points, PoseTask& task, Random& random);

// Whether `right` of n corners agree on a pose better than wrong ones would by chance (a contrario:
// the expected number of such agreements below 1e-4), wrong ones being anywhere in the image.
bool beyond_chance(std::size_t n, std::size_t right, double sigma_px);

// Some of 0 .. n - 1, each set of so many as likely, ascending.
std::vector<std::size_t> some_of(std::size_t n, std::size_t how_many, Random& random);

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
