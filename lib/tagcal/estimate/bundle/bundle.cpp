#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/refine_pose.hpp"

// The state of a calibration, and its costs.

namespace tagcal::internal {

Vector6d moved_twist(const Pose& target_from_source, const Vector6d& twist) {
  Vector6d moved;
  moved.head<3>() = target_from_source.rotation() * twist.head<3>();
  moved.tail<3>() = target_from_source.rotation() * twist.tail<3>() +
                    target_from_source.translation().cross(moved.head<3>());
  return moved;
}

Matrix6 step_from_twist(const Pose& pose) {
  Matrix6 step = Matrix6::Identity();
  step.bottomLeftCorner<3, 3>() = -cross_matrix(pose.translation());
  return step;
}

Vector6d Bundle::twist_unit() const {
  const double focal_px = policy::kPriorFocal * image_size.width;
  Vector6d unit;
  unit << Eigen::Vector3d::Constant(1 / focal_px), Eigen::Vector3d::Constant(rolling_m / focal_px);
  return unit;
}

ViewRowTerms Bundle::row_prior(std::size_t view) const {
  ViewRowTerms rows{middle_row(), row_sigma > 0 ? row_sigma / sigma : 0};
  if (!is_rolling()) return rows;
  const Pose& pose = camera_from_target[view];
  rows.velocities = step_from_twist(pose) * twist_unit().asDiagonal();
  if (!row_terms.empty())
    rows.start = moved_twist(pose, row_terms[view]).cwiseQuotient(twist_unit());
  return rows;
}

const ViewProblem& Bundle::corrected(const ViewProblem& observed, const Vector6d& rows,
                                     ViewProblem& buffer) const {
  if (!board && rows.isZero()) return observed;
  buffer = observed;
  ViewArrays arrays(observed);
  if (board) arrays.displace(board->shapes(arrays.points()).view(), shape);
  std::vector<Correspondence>& corners = buffer.correspondences.own();
  if (is_rolling()) arrays.move_rows(rows, middle_row());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i].point = arrays.points()[i];
    if (!is_rolling()) corners[i].pixel -= (corners[i].pixel.y() - middle_row()) * rows.head<2>();
  }
  return buffer;
}

const ViewProblem& Bundle::corrected(std::size_t view, ViewProblem& buffer) const {
  return corrected(views[view], row_terms.empty() ? Vector6d(Vector6d::Zero()) : row_terms[view],
                   buffer);
}

Bundle Bundle::without_views() const {
  return {model, image_size, free_values, {}, {},    board,
          shape, row_sigma,  rolling_m,   {}, sigma, known_lens};
}

PriorRows prior_of_lens(const Bundle& bundle) {
  if (const auto& known = bundle.known_lens) {
    const auto x = Eigen::VectorXd::Map(bundle.free_values.data(), known->values.size());
    return {known->root * (x - known->values), known->root};
  }
  return lens_prior(*bundle.model, bundle.free_values, bundle.image_size);
}

PriorRows prior_of(const Bundle& bundle) {
  PriorRows rows = prior_of_lens(bundle);
  if (!bundle.board) return rows;
  const Eigen::Index of_lens = rows.residuals.size(), k = rows.by_parameters.cols();
  const Eigen::Index n = bundle.num_shapes();
  rows.residuals.conservativeResize(of_lens + n);
  Eigen::MatrixXd by_all = Eigen::MatrixXd::Zero(of_lens + n, k + n);
  by_all.topLeftCorner(of_lens, k) = rows.by_parameters;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double sigma = bundle.board->prior_sigma[i];
    const StudentResidual residual = student_residual(bundle.shape[i] / sigma);
    rows.residuals[of_lens + i] = residual.value;
    by_all(of_lens + i, k + i) = residual.by_z / sigma;
  }
  rows.by_parameters = by_all;
  return rows;
}

double cost_of(const Bundle& bundle) {
  double sum = 0;
  const Lens lens = bundle.lens();
  ViewProblem buffer;
  for (std::size_t v = 0; v < bundle.views.size(); ++v)
    for (const double square :
         whitened_squares(bundle.corrected(v, buffer), lens, bundle.camera_from_target[v]))
      sum += square;
  return sum;
}

std::optional<RefinedPose> refine_view_pose(const ViewProblem& view, const Lens& lens,
                                            const Pose& start, int max_iterations) {
  const ViewArrays arrays(view);
  ViewSums sums(lens, arrays.view());
  const auto solution = refine_pose<6>(sums, {state_of(start)}, {max_iterations});
  if (!solution) return std::nullopt;
  return RefinedPose{pose_of(solution->state), solution->cost, solution->converged};
}

std::optional<Eigen::MatrixXd> products_of(const Bundle& bundle, std::size_t view,
                                           std::span<const FreeParameter> free, const Lens& lens,
                                           const Pose& camera_from_target) {
  ViewEquations equations(bundle, view, free, bundle.row_prior(view));
  Eigen::MatrixXd gram;
  if (!equations.sums.at(lens, camera_from_target, gram)) return std::nullopt;
  return gram;
}

std::optional<Eigen::MatrixXd> products_of(const ViewProblem& view,
                                           std::span<const FreeParameter> free, const Lens& lens,
                                           const Pose& camera_from_target,
                                           const ViewRowTerms& rows) {
  const ViewArrays arrays(view);
  ParameterSums sums(arrays.view(), free, {}, rows);
  Eigen::MatrixXd gram;
  if (!sums.at(lens, camera_from_target, gram)) return std::nullopt;
  return gram;
}

std::optional<ParameterSums::RowEquations> row_equations(const Bundle& bundle, std::size_t view,
                                                         const Lens& lens) {
  ViewRowTerms rows = bundle.row_prior(view);
  rows.sigma = 1e6;  // numeric: weak enough to leave the sums as they are
  ViewEquations equations(bundle, view, {}, rows);
  Eigen::MatrixXd gram;
  if (!equations.sums.at(lens, bundle.camera_from_target[view], gram)) return std::nullopt;
  return equations.sums.row_equations();
}

}  // namespace tagcal::internal
