#pragma once

#include <optional>
#include <vector>

#include "tagcal/estimate/pose/reprojection.hpp"

namespace tagcal::internal {

struct RefinedPose {
  Pose camera_from_target;
  double cost = 0;  // sum of squared whitened residuals
  bool converged = false;
};

// The pose of one view that is most likely for a known lens: Levenberg-Marquardt
// (ceres::TinySolver) on the residuals from a start in which every point is in the lens' domain; no
// value else.
std::optional<RefinedPose> refine_pose(const ViewProblem& view, const Lens& lens, const Pose& start,
                                       int max_iterations = 50);

// A calibration problem and its state: the free parameters of a model and the pose of every view.
struct Bundle {
  const Model* model = nullptr;
  ImageSize image_size;
  std::vector<double> free_values;
  std::vector<ViewProblem> views;
  std::vector<Pose> camera_from_target;  // per view

  // Precondition: the values make a lens, as those of a solved bundle do.
  Lens lens() const { return *model->lens(free_values, image_size); }
};

// The sum of the squared whitened residuals of all views.
double cost_of(const Bundle& bundle);

struct BundleSummary {
  bool converged = false;
  double cost = 0;  // sum of squared whitened residuals
  int num_iterations = 0;
};

// Maximum likelihood over all poses and free parameters: Ceres, one residual block a view, poses
// eliminated by the Schur complement. Equal input gives equal bytes whatever the number of threads
// (0: one a core): they evaluate views, and Ceres sums on one. The state moves to the solution,
// unless a point is outside the domain at the start: then it stays and `converged` is false.
BundleSummary solve(Bundle& bundle, int max_iterations, std::size_t num_threads = 1);

}  // namespace tagcal::internal
