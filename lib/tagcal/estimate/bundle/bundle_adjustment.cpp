#include "tagcal/estimate/bundle/bundle_adjustment.hpp"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <Eigen/LU>
#include <cmath>
#include <memory>
#include <mutex>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/refine_pose.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal::internal {
namespace {

// A pose relative to its start: omega (rad), and tau in units of the start's distance. Rotations
// and translations then have the same scale for the solver, whatever the unit of length is.
struct PoseStep {
  Pose reference;
  double length = 1;

  Pose at(const Vector6d& step) const {
    Vector6d scaled = step;
    scaled.tail<3>() *= length;
    return retract(reference, scaled);
  }
};

PoseStep step_about(const Pose& pose) {
  const double distance = pose.translation().norm();
  return {pose, distance > 0 ? distance : 1.0};
}

// The compressed rows [J | r] of a view at the solver's current state. It holds nothing per corner:
// of ten thousand views that would be most of the memory.
struct ViewRows {
  std::size_t view;  // of the bundle
  PoseStep pose;
  Vector6d step = Vector6d::Zero();  // what the solver varies
  bool valid = false;                // no corner is outside of the lens' domain
  Eigen::MatrixXd rows;

  ViewRows(const Bundle& bundle, std::size_t v)
      : view(v), pose(step_about(bundle.camera_from_target[v])) {}

  // Computes the rows for a lens and the shape of the bundle's board.
  void evaluate(const Bundle& bundle, const Lens& lens) {
    ViewEquations equations(bundle, view, bundle.model->free(), bundle.row_prior());
    Eigen::MatrixXd gram;
    valid = equations.sums.at(lens, pose.at(step), gram);
    if (valid) compressed_rows(gram, 6, rows);
  }
};

// The cost of all corners of one view; parameter blocks are the pose step (6), the free parameters
// and the shape of the board (k together). Ceres gets 6 + k + 1 rows instead of two per corner,
// because copying those took most of its time.
class ViewCost : public ceres::CostFunction {
 public:
  ViewCost(const ViewRows& view, const Bundle& bundle) : view_(view) {
    set_num_residuals(6 + bundle.num_parameters() + 1);
    const int num_free = bundle.model->num_free();
    mutable_parameter_block_sizes()->push_back(6);
    if (num_free > 0) mutable_parameter_block_sizes()->push_back(num_free);
    if (bundle.board) mutable_parameter_block_sizes()->push_back(bundle.num_shapes());
  }

  bool Evaluate(const double* const* /*parameters*/, double* residuals,
                double** jacobians) const override {
    if (!view_.valid) return false;
    const Eigen::MatrixXd& rows = view_.rows;
    const Eigen::Index n = rows.rows();
    Eigen::Map<Eigen::VectorXd>(residuals, n) = rows.col(n - 1);
    if (jacobians && jacobians[0]) {
      Eigen::Map<RowMajor6> by_step(jacobians[0], n, 6);
      by_step.leftCols<3>().noalias() =
          rows.leftCols<3>().lazyProduct(left_jacobian(view_.step.head<3>()));
      by_step.rightCols<3>() = view_.pose.length * rows.middleCols<3>(3);
    }
    Eigen::Index column = 6;
    for (std::size_t b = 1; jacobians && b < parameter_block_sizes().size(); ++b) {
      const int k = parameter_block_sizes()[b];
      if (jacobians[b]) Eigen::Map<RowMajorX>(jacobians[b], n, k) = rows.middleCols(column, k);
      column += k;
    }
    return true;
  }

 private:
  const ViewRows& view_;
};

// The cost of the priors; parameter blocks are the free parameters and the shape of the board.
class PriorCost : public ceres::CostFunction {
 public:
  explicit PriorCost(const Bundle& bundle) : bundle_(bundle) {
    set_num_residuals(static_cast<int>(prior_of(bundle).residuals.size()));
    if (bundle.model->num_free() > 0)
      mutable_parameter_block_sizes()->push_back(bundle.model->num_free());
    if (bundle.board) mutable_parameter_block_sizes()->push_back(bundle.num_shapes());
  }

  // The parameters are those of the bundle.
  bool Evaluate(const double* const* /*parameters*/, double* residuals,
                double** jacobians) const override {
    if (!bundle_.model->lens(bundle_.free_values, bundle_.image_size)) return false;
    const PriorRows rows = prior_of(bundle_);
    const Eigen::Index n = rows.residuals.size();
    Eigen::Map<Eigen::VectorXd>(residuals, n) = bundle_.sigma * rows.residuals;
    Eigen::Index column = 0;
    for (std::size_t b = 0; jacobians && b < parameter_block_sizes().size(); ++b) {
      const int k = parameter_block_sizes()[b];
      if (jacobians[b])
        Eigen::Map<RowMajorX>(jacobians[b], n, k) =
            bundle_.sigma * rows.by_parameters.middleCols(column, k);
      column += k;
    }
    return true;
  }

 private:
  const Bundle& bundle_;
};

// Computes the lens and the rows of all views once for each new state of the solver. (Ceres asks
// for the cost there first, and for the Jacobian if it accepts the step.)
class Evaluation : public ceres::EvaluationCallback {
 public:
  Evaluation(const Bundle& bundle, std::vector<ViewRows>& views, std::size_t num_threads)
      : bundle_(bundle), views_(views), num_threads_(num_threads) {}

  void PrepareForEvaluation(bool /*jacobians*/, bool is_new_point) override {
    if (!is_new_point) return;
    const std::optional<Lens> lens = bundle_.model->lens(bundle_.free_values, bundle_.image_size);
    parallel_for(views_.size(), threads_for_short_calls(views_.size(), num_threads_),
                 [&](std::size_t i) {
                   ViewRows& view = views_[i];
                   view.valid = false;
                   if (lens) view.evaluate(bundle_, *lens);
                 });
  }

 private:
  const Bundle& bundle_;
  std::vector<ViewRows>& views_;
  std::size_t num_threads_;
};

// Silences glog: Ceres prints through it when an evaluation fails, whatever the options say.
void silence_logging() {
  static std::once_flag once;
  std::call_once(once, [] {
    if (!google::IsGoogleLoggingInitialized()) google::InitGoogleLogging("tagcal");
    FLAGS_minloglevel = google::GLOG_FATAL;
  });
}

ceres::Solver::Options solver_options(int max_iterations) {
  ceres::Solver::Options options;
  options.max_num_iterations = max_iterations;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.num_threads = 1;
  // Starts are near the minimum, so the first steps should be those of Gauss-Newton. The default
  // radius damps weakly determined parameters and needs twice as many steps.
  options.initial_trust_region_radius = 1e8;
  options.function_tolerance = 1e-12;   // numeric: near the rounding of the sums
  options.gradient_tolerance = 1e-12;   // numeric: near the rounding of the sums
  options.parameter_tolerance = 1e-12;  // numeric: near the rounding of the sums
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

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
  return {model, image_size, free_values, {}, {}, board, shape, row_sigma, {}, sigma};
}

PriorRows prior_of(const Bundle& bundle) {
  PriorRows rows = lens_prior(*bundle.model, bundle.free_values, bundle.image_size);
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

namespace {

// Sets the row terms that are best at the state, and the data's part of the cost.
void set_row_terms(Bundle& bundle, BundleSummary& summary, std::size_t num_threads) {
  const std::size_t n = bundle.views.size();
  bundle.row_terms.assign(n, Eigen::Vector2d::Zero());
  const auto lens = bundle.model->lens(bundle.free_values, bundle.image_size);
  if (!lens || !(bundle.row_sigma > 0)) return;
  const double variance = bundle.row_prior().sigma * bundle.row_prior().sigma;
  std::vector<double> volumes(n);
  parallel_for(n, threads_for_short_calls(n, num_threads), [&](std::size_t v) {
    ViewArrays arrays(bundle.views[v]);
    if (bundle.board) arrays.displace(bundle.board->shapes(arrays.points()).view(), bundle.shape);
    ParameterSums sums(arrays.view(), {}, {}, bundle.row_prior());
    Eigen::MatrixXd gram;
    if (!sums.at(*lens, bundle.camera_from_target[v], gram)) return;
    bundle.row_terms[v] = sums.row_terms();
    const Eigen::Matrix2d volume =
        Eigen::Matrix2d::Identity() + variance * sums.row_equations().information;
    volumes[v] = std::log(std::max(1.0, volume.determinant()));
  });
  for (const double volume : volumes) summary.row_volume += volume;
  const double prior = bundle.sigma / bundle.row_sigma;
  for (const Eigen::Vector2d& rows : bundle.row_terms)
    summary.prior += prior * prior * rows.squaredNorm();
}

}  // namespace

BundleSummary solve(Bundle& bundle, int max_iterations, std::size_t num_threads) {
  silence_logging();
  // Contiguous and never reallocated, because Ceres orders parameter blocks by their addresses.
  std::vector<ViewRows> views;
  views.reserve(bundle.views.size());
  Evaluation evaluation(bundle, views, num_threads);
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &evaluation;
  ceres::Problem problem(problem_options);
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  std::vector<double*> common;
  if (bundle.model->num_free() > 0) common.push_back(bundle.free_values.data());
  if (bundle.board) common.push_back(bundle.shape.data());
  for (std::size_t i = 0; i < bundle.views.size(); ++i) {
    ViewRows& view = views.emplace_back(bundle, i);
    std::vector<double*> blocks = {view.step.data()};
    blocks.insert(blocks.end(), common.begin(), common.end());
    problem.AddResidualBlock(new ViewCost(view, bundle), nullptr, blocks);
    ordering->AddElementToGroup(view.step.data(), 0);
  }
  if (!common.empty()) problem.AddResidualBlock(new PriorCost(bundle), nullptr, common);
  // A group of its own each: within one, the order is that of the addresses, and those of heap and
  // stack differ between threads.
  for (std::size_t i = 0; i < common.size(); ++i)
    ordering->AddElementToGroup(common[i], static_cast<int>(i) + 1);
  ceres::Solver::Options options = solver_options(max_iterations);
  options.linear_solver_ordering = ordering;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  for (std::size_t i = 0; i < views.size(); ++i)
    bundle.camera_from_target[i] = views[i].pose.at(views[i].step);
  BundleSummary result;
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  result.num_iterations = static_cast<int>(summary.iterations.size());
  result.prior = bundle.sigma * bundle.sigma * prior_of(bundle).residuals.squaredNorm();
  set_row_terms(bundle, result, num_threads);
  result.cost = std::max(0.0, 2 * summary.final_cost - result.prior);
  return result;
}

}  // namespace tagcal::internal
