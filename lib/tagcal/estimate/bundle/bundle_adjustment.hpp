#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/pose/reprojection.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// The displacements of a view's points by a unit of each bend, and their direction.
struct BoardShapes {
  std::vector<Eigen::Vector2d> of_points;  // empty without a bend
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();

  ViewBend view() const { return {of_points, normal}; }
};

// The flat board of a data set with one board, for a bend of two parameters: a point at (x, y)
// moves out of the plane by bend.x (1 - x'^2) + bend.y (1 - y'^2), with x' and y' from -1 to 1 over
// the board (after mrcal's calobject_warp).
struct FlatBoard {
  Pose world_from_board;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();     // board frame, metres
  Eigen::Vector2d half_size = Eigen::Vector2d::Ones();  // metres

  // The same for a flat and for a bent board, because a bend does not move points in the plane.
  BoardShapes shapes(std::span<const Eigen::Vector3d> x_in_world) const;
  void bend(ViewProblem& view, const Eigen::Vector2d& by_m) const;  // moves the view's points
};

// No value if there are several boards, or if the board has thickness or no extent.
std::optional<FlatBoard> flat_board(const Dataset& dataset);

struct RefinedPose {
  Pose camera_from_target;
  double cost = 0;  // sum of squared whitened residuals
  bool converged = false;
};

// Maximum likelihood pose of one view for a known lens, from a start: Levenberg-Marquardt of
// refine_pose.hpp on the whitened residuals. No value if a point is outside the lens' domain at the
// start.
std::optional<RefinedPose> refine_view_pose(const ViewProblem& view, const Lens& lens,
                                            const Pose& start, int max_iterations = 50);

// A calibration problem and its state: the free parameters of a model, the bend of the board if it
// is estimated, and one pose for each view.
struct Bundle {
  const Model* model = nullptr;
  ImageSize image_size;
  std::vector<double> free_values;
  std::vector<ViewProblem> views;
  std::vector<Pose> camera_from_target;  // per view
  std::optional<FlatBoard> bent_board;   // its two bends are parameters, after those of the model
  Eigen::Vector2d bend_m = Eigen::Vector2d::Zero();  // included in the points of the views

  // Precondition: the free values are in the domain of the model, as those of a solved bundle are.
  Lens lens() const { return *model->lens(free_values, image_size); }
  int num_parameters() const { return model->num_free() + (bent_board ? 2 : 0); }  // of lens, board

  // A view given with the points of the flat board, with those of the bent board: `flat` itself
  // without a bend, else `buffer`.
  const ViewProblem& bent(const ViewProblem& flat, ViewProblem& buffer) const;

  Bundle without_views() const;
};

// The sum of the squared whitened residuals of all views.
double cost_of(const Bundle& bundle);

struct BundleSummary {
  bool converged = false;
  double cost = 0;  // sum of squared whitened residuals
  int num_iterations = 0;
};

// Maximum likelihood over all poses and free parameters: Ceres, one residual block per view, poses
// eliminated by the Schur complement. Equal input gives equal bytes for any number of threads (0:
// one per core), because threads evaluate views and Ceres sums on one thread. Writes the solution
// into the bundle. If a point is outside the lens' domain at the start, the bundle stays as it is
// and `converged` is false.
BundleSummary solve(Bundle& bundle, int max_iterations, std::size_t num_threads = 1);

}  // namespace tagcal::internal
