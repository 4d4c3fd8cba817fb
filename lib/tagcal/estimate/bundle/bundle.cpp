#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/estimate/pose/refine_pose.hpp"

// The state of a calibration, and its costs.

namespace tagcal::internal {

const ViewProblem& Bundle::corrected(const ViewProblem& observed, const Eigen::Vector2d& rows,
                                     ViewProblem& buffer) const {
  if (!board && rows.isZero()) return observed;
  buffer = observed;
  ViewArrays arrays(observed);
  if (board) arrays.displace(board->shapes(arrays.points()).view(), shape);
  std::vector<Correspondence>& corners = buffer.correspondences.own();
  const double middle_row = image_centre(image_size).y();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i].point = arrays.points()[i];
    corners[i].pixel -= (corners[i].pixel.y() - middle_row) * rows;
  }
  return buffer;
}

const ViewProblem& Bundle::corrected(std::size_t view, ViewProblem& buffer) const {
  return corrected(views[view], row_terms.empty() ? Eigen::Vector2d(0, 0) : row_terms[view],
                   buffer);
}

Bundle Bundle::without_views() const {
  return {model, image_size, free_values, {}, {}, board, shape, row_sigma, {}, sigma, known_lens};
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
  ViewEquations equations(bundle, view, free, bundle.row_prior());
  Eigen::MatrixXd gram;
  if (!equations.sums.at(lens, camera_from_target, gram)) return std::nullopt;
  return gram;
}

}  // namespace tagcal::internal
