#include "tagcal/estimate/bundle/bundle_adjustment.hpp"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <memory>
#include <mutex>

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

// The compressed rows [J | r] of a view at the solver's current state.
struct ViewRows {
  ViewArrays arrays;
  ParameterSums sums;
  PoseStep pose;
  Vector6d step = Vector6d::Zero();  // what the solver varies
  bool valid = false;                // no corner is outside of the lens' domain
  Eigen::MatrixXd gram, rows;

  ViewRows(const ViewProblem& view, const Model& model, const Pose& start)
      : arrays(view), sums(arrays.view(), model.free()), pose(step_about(start)) {}
};

// The cost of all corners of one view; parameter blocks are the pose step (6) and the free
// parameters (k). Ceres gets 6 + k + 1 rows instead of two per corner, because copying those took
// most of its time.
class ViewCost : public ceres::CostFunction {
 public:
  ViewCost(const ViewRows& view, int num_free) : view_(view), num_free_(num_free) {
    set_num_residuals(static_cast<int>(view.sums.num_columns()));
    mutable_parameter_block_sizes()->push_back(6);
    if (num_free > 0) mutable_parameter_block_sizes()->push_back(num_free);
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
    if (jacobians && num_free_ > 0 && jacobians[1])
      Eigen::Map<RowMajorX>(jacobians[1], n, num_free_) = rows.middleCols(6, num_free_);
    return true;
  }

 private:
  const ViewRows& view_;
  const int num_free_;
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
                   view.valid = lens && view.sums.at(*lens, view.pose.at(view.step), view.gram);
                   if (view.valid) compressed_rows(view.gram, view.rows);
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

double cost_of(const Bundle& bundle) {
  double sum = 0;
  const Lens lens = bundle.lens();
  for (std::size_t v = 0; v < bundle.views.size(); ++v)
    for (const double square :
         whitened_squares(bundle.views[v], lens, bundle.camera_from_target[v]))
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
  const int k = bundle.model->num_free();
  for (std::size_t i = 0; i < bundle.views.size(); ++i) {
    ViewRows& view =
        views.emplace_back(bundle.views[i], *bundle.model, bundle.camera_from_target[i]);
    std::vector<double*> blocks = {view.step.data()};
    if (k > 0) blocks.push_back(bundle.free_values.data());
    problem.AddResidualBlock(new ViewCost(view, k), nullptr, blocks);
    ordering->AddElementToGroup(view.step.data(), 0);
  }
  if (k > 0) ordering->AddElementToGroup(bundle.free_values.data(), 1);
  ceres::Solver::Options options = solver_options(max_iterations);
  options.linear_solver_ordering = ordering;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  for (std::size_t i = 0; i < views.size(); ++i)
    bundle.camera_from_target[i] = views[i].pose.at(views[i].step);
  return {summary.termination_type == ceres::CONVERGENCE, 2 * summary.final_cost,
          static_cast<int>(summary.iterations.size())};
}

}  // namespace tagcal::internal
