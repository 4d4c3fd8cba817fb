#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/bundle/flat_board.hpp"
#include "tagcal/estimate/bundle/lens_prior.hpp"
#include "tagcal/estimate/bundle/linked_poses.hpp"
#include "tagcal/estimate/pose/reprojection.hpp"

namespace tagcal::internal {

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

// The prior of a lens that was calibrated before, instead of lens_prior: `root` (x - values) are
// its residuals.
struct KnownLens {
  Eigen::VectorXd values;
  Eigen::MatrixXd root;
};

// A calibration problem and its state: the free parameters of a model, the shape of the board, and
// for each view a pose and row terms.
struct Bundle {
  const Model* model = nullptr;
  ImageSize image_size;
  std::vector<double> free_values;
  std::vector<ViewProblem> views;        // as observed, with points of the flat board
  std::vector<Pose> camera_from_target;  // per view
  std::optional<FlatBoard> board;        // whose shapes are parameters, after those of the model
  BoardShape shape = BoardShape::Zero();
  double row_sigma = 0;  // px a row, of the row terms (ViewRowTerms); 0: none
  double rolling_m = 0;  // the corners' distance, if the row terms are velocities; else 0
  // Per view; zero without any. Velocities are those of the board, a twist in its frame, in rad and
  // m a row; they are parameters of the solution, and start from what stands here.
  std::vector<Vector6d> row_terms;
  double sigma = 1;  // noise per (whitened) coordinate, against which the priors are weighed
  std::optional<KnownLens> known_lens = {};

  // Precondition: the free values are in the domain of the model, as those of a solved bundle are.
  Lens lens() const { return *model->lens(free_values, image_size); }
  int num_parameters() const { return model->num_free() + num_shapes(); }  // of lens and board
  int num_shapes() const { return board ? static_cast<int>(BoardShape::SizeAtCompileTime) : 0; }
  double middle_row() const { return image_centre(image_size).y(); }
  bool is_rolling() const { return rolling_m > 0; }
  // The turn (rad) and the move (m) of a camera that displace the pixels of a usual lens by one, at
  // the distance of the corners: twists along each axis of the camera are normal in these units.
  Vector6d twist_unit() const;
  // The poses are those that the solver starts from.
  ViewRowTerms row_prior(std::size_t view) const;

  // A view as this board without its row terms shows it: `observed` itself without both, else
  // `buffer`.
  const ViewProblem& corrected(const ViewProblem& observed, const Vector6d& row_terms,
                               ViewProblem& buffer) const;
  const ViewProblem& corrected(std::size_t view, ViewProblem& buffer) const;

  Bundle without_views() const;
};

// A twist (omega, v) gives a point x the velocity cross(omega, x) + v: that of the source frame in
// the target frame (the adjoint of the pose), and the step of `retract` by one in the target frame.
Vector6d moved_twist(const Pose& target_from_source, const Vector6d& twist);
Matrix6 step_from_twist(const Pose& pose);

// A view of a bundle as the kernels take it, at the bundle's state; both must outlive it.
struct ViewEquations {
  ViewArrays arrays;
  BoardShapes shapes;
  ParameterSums sums;

  ViewEquations(const Bundle& bundle, std::size_t view, std::span<const FreeParameter> free,
                const ViewRowTerms& rows)
      : arrays(bundle.views[view]),
        shapes(bundle.board ? bundle.board->shapes(arrays.points()) : BoardShapes{}),
        sums((displace(bundle, view), arrays.view()), free, shapes.view(), rows) {}

 private:
  void displace(const Bundle& bundle, std::size_t view) {
    arrays.displace(shapes.view(), bundle.shape);
    if (bundle.is_rolling() && !bundle.row_terms.empty())
      arrays.move_rows(bundle.row_terms[view], bundle.middle_row());
  }
};

// The products [J | r]'[J | r] (upper triangle) of a view's rows, with J by a step of this pose,
// the free parameters and the shapes of the board. No value if a point is outside the lens' domain.
std::optional<Eigen::MatrixXd> products_of(const Bundle& bundle, std::size_t view,
                                           std::span<const FreeParameter> free, const Lens& lens,
                                           const Pose& camera_from_target);
// The same of a view alone, without the shapes of a board.
std::optional<Eigen::MatrixXd> products_of(const ViewProblem& view,
                                           std::span<const FreeParameter> free, const Lens& lens,
                                           const Pose& camera_from_target,
                                           const ViewRowTerms& rows = {});

// The equations of a view's row terms, of the bundle's kind, for a lens. No value if a point is
// outside its domain.
std::optional<ParameterSums::RowEquations> row_equations(const Bundle& bundle, std::size_t view,
                                                         const Lens& lens);

// The pseudo-observations of lens and board, by all parameters of the bundle.
PriorRows prior_of(const Bundle& bundle);
// The same without those of the board, whose parameters have no rows then.
PriorRows prior_of_lens(const Bundle& bundle);

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

// Maximum a posteriori over all poses and free parameters of cameras on one body, which see the
// same board: Ceres, one residual block per view, the poses of the instants eliminated by the Schur
// complement, and the pseudo-observations of lenses, board and row terms. The shape of the board is
// that of the first bundle. Equal input gives equal bytes for any number of threads (0: one per
// core), because threads evaluate views and Ceres sums on one thread. Writes the solution into the
// poses and the bundles. If a point is outside a lens' domain at the start, they stay as they are
// and `converged` is false.
BundleSummary solve(std::span<Bundle> cameras, LinkedPoses& poses, int max_iterations,
                    std::size_t num_threads = 1);

// The same for one camera.
BundleSummary solve(Bundle& bundle, int max_iterations, std::size_t num_threads = 1);

}  // namespace tagcal::internal
