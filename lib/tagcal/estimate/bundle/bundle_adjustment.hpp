#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/bundle/lens_prior.hpp"
#include "tagcal/estimate/pose/reprojection.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// The displacements of a view's points by a unit of each shape of their board, and their
// directions.
struct BoardShapes {
  std::vector<Eigen::Vector4d> of_points;  // empty without a board
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Vector3d across = Eigen::Vector3d::Zero();

  ViewShapes view() const { return {of_points, normal, across}; }
};

// How a board differs from its file: a point at (x, y) of the board, with x' and y' from -1 to 1
// over it, is out of its plane by
//   shape[0] (1 - x'^2) + shape[1] (1 - y'^2) + shape[2] x' y'   metres (bends after mrcal, twist)
// and at y (1 + shape[3]) instead of y (print aspect).
using BoardShape = Eigen::Vector4d;

// The flat board of a data set with one board.
struct FlatBoard {
  Pose world_from_board;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();     // board frame, metres
  Eigen::Vector2d half_size = Eigen::Vector2d::Ones();  // metres
  BoardShape prior_sigma = BoardShape::Ones();          // of each shape, about zero
  Substrate substrate;                                  // from which it follows

  BoardShapes shapes(std::span<const Eigen::Vector3d> x_in_world) const;
};

// No value if there are several boards, or if the board has thickness or no extent. Throws Error
// for a substrate out of its range.
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

// A calibration problem and its state: the free parameters of a model, the shape of the board, and
// for each view a pose and two row terms.
struct Bundle {
  const Model* model = nullptr;
  ImageSize image_size;
  std::vector<double> free_values;
  std::vector<ViewProblem> views;        // as observed, with points of the flat board
  std::vector<Pose> camera_from_target;  // per view
  std::optional<FlatBoard> board;        // whose shapes are parameters, after those of the model
  BoardShape shape = BoardShape::Zero();
  double row_sigma = 0;                    // px a row, of the row terms (ViewRowTerms); 0: none
  std::vector<Eigen::Vector2d> row_terms;  // per view; zero without any
  double sigma = 1;  // noise per (whitened) coordinate, against which the priors are weighed

  // Precondition: the free values are in the domain of the model, as those of a solved bundle are.
  Lens lens() const { return *model->lens(free_values, image_size); }
  int num_parameters() const { return model->num_free() + num_shapes(); }  // of lens and board
  int num_shapes() const { return board ? static_cast<int>(BoardShape::SizeAtCompileTime) : 0; }
  ViewRowTerms row_prior() const {
    return {image_centre(image_size).y(), row_sigma > 0 ? row_sigma / sigma : 0};
  }

  // A view as this board without its row terms shows it: `observed` itself without both, else
  // `buffer`.
  const ViewProblem& corrected(const ViewProblem& observed, const Eigen::Vector2d& row_terms,
                               ViewProblem& buffer) const;
  const ViewProblem& corrected(std::size_t view, ViewProblem& buffer) const;

  Bundle without_views() const;
};

// The pseudo-observations of lens and board, by all parameters of the bundle.
PriorRows prior_of(const Bundle& bundle);

// The sum of the squared whitened residuals of all views.
double cost_of(const Bundle& bundle);

struct BundleSummary {
  bool converged = false;
  double cost = 0;   // sum of squared whitened residuals
  double prior = 0;  // and what the priors add, in the same unit
  // Twice the logarithm of the volume of the row terms' prior over their posterior's: what the
  // evidence charges for them.
  double row_volume = 0;
  int num_iterations = 0;
};

// Maximum a posteriori over all poses and free parameters: Ceres, one residual block per view,
// poses eliminated by the Schur complement, and the pseudo-observations of lens, board and row
// terms. Equal input gives equal bytes for any number of threads (0: one per core), because threads
// evaluate views and Ceres sums on one thread. Writes the solution into the bundle. If a point is
// outside the lens' domain at the start, the bundle stays as it is and `converged` is false.
BundleSummary solve(Bundle& bundle, int max_iterations, std::size_t num_threads = 1);

}  // namespace tagcal::internal
