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

// The compressed rows [J | r] of a view at the solver's current state. It holds nothing per corner:
// of ten thousand views that would be most of the memory.
struct ViewRows {
  const ViewProblem& view;  // at the start
  PoseStep pose;
  Vector6d step = Vector6d::Zero();  // what the solver varies
  bool valid = false;                // no corner is outside of the lens' domain
  Eigen::MatrixXd rows;

  ViewRows(const Bundle& bundle, std::size_t v)
      : view(bundle.views[v]), pose(step_about(bundle.camera_from_target[v])) {}

  // Computes the rows for a lens, and a bend of the bundle's board `by_m` from the start.
  void evaluate(const Bundle& bundle, const Lens& lens, const Eigen::Vector2d& by_m) {
    ViewArrays arrays(view);
    const BoardShapes bends =
        bundle.bent_board ? bundle.bent_board->shapes(arrays.points()) : BoardShapes{};
    for (std::size_t i = 0; i < bends.of_points.size(); ++i)
      arrays.points()[i] += bends.of_points[i].dot(by_m) * bends.normal;
    ParameterSums sums(arrays.view(), bundle.model->free(), bends.view());
    Eigen::MatrixXd gram;
    valid = sums.at(lens, pose.at(step), gram);
    if (valid) compressed_rows(gram, rows);
  }
};

// The cost of all corners of one view; parameter blocks are the pose step (6), the free parameters
// and the bend (k together). Ceres gets 6 + k + 1 rows instead of two per corner, because copying
// those took most of its time.
class ViewCost : public ceres::CostFunction {
 public:
  ViewCost(const ViewRows& view, const Bundle& bundle) : view_(view) {
    set_num_residuals(6 + bundle.num_parameters() + 1);
    const int num_free = bundle.model->num_free();
    mutable_parameter_block_sizes()->push_back(6);
    if (num_free > 0) mutable_parameter_block_sizes()->push_back(num_free);
    if (bundle.bent_board) mutable_parameter_block_sizes()->push_back(2);
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

// Computes the lens and the rows of all views once for each new state of the solver. (Ceres asks
// for the cost there first, and for the Jacobian if it accepts the step.)
class Evaluation : public ceres::EvaluationCallback {
 public:
  Evaluation(const Bundle& bundle, std::vector<ViewRows>& views, std::size_t num_threads)
      : bundle_(bundle), start_bend_m_(bundle.bend_m), views_(views), num_threads_(num_threads) {}

  void PrepareForEvaluation(bool /*jacobians*/, bool is_new_point) override {
    if (!is_new_point) return;
    const std::optional<Lens> lens = bundle_.model->lens(bundle_.free_values, bundle_.image_size);
    parallel_for(views_.size(), threads_for_short_calls(views_.size(), num_threads_),
                 [&](std::size_t i) {
                   ViewRows& view = views_[i];
                   view.valid = false;
                   if (lens) view.evaluate(bundle_, *lens, bundle_.bend_m - start_bend_m_);
                 });
  }

 private:
  const Bundle& bundle_;  // its views are those of the start
  const Eigen::Vector2d start_bend_m_;
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

BoardShapes FlatBoard::shapes(std::span<const Eigen::Vector3d> x_in_world) const {
  const Pose board_from_world = world_from_board.inverse();
  BoardShapes result{{}, world_from_board.rotation() * Eigen::Vector3d::UnitZ()};
  result.of_points.reserve(x_in_world.size());
  for (const Eigen::Vector3d& x : x_in_world) {
    const Eigen::Vector2d in_board = (board_from_world * x).head<2>() - centre;
    result.of_points.push_back(Eigen::Vector2d::Ones() -
                               in_board.cwiseQuotient(half_size).cwiseAbs2());
  }
  return result;
}

void FlatBoard::bend(ViewProblem& view, const Eigen::Vector2d& by_m) const {
  const BoardShapes bends = shapes(ViewArrays(view).view().points);
  std::vector<Correspondence>& corners = view.correspondences.own();
  for (std::size_t i = 0; i < corners.size(); ++i)
    corners[i].point += bends.of_points[i].dot(by_m) * bends.normal;
}

std::optional<FlatBoard> flat_board(const Dataset& dataset) {
  if (dataset.boards.size() != 1) return std::nullopt;
  const auto points = target_points(dataset.boards[0].board);
  if (points.empty()) return std::nullopt;
  Eigen::Vector3d low = points[0].position, high = low;
  for (const TargetPoint& p : points) {
    low = low.cwiseMin(p.position);
    high = high.cwiseMax(p.position);
  }
  const Eigen::Vector3d size = high - low;
  const double rounding_m = 1e-6 * size.x();  // numeric: of positions in a file
  if (!(size.x() > 0 && size.y() > 0) || size.z() > rounding_m) return std::nullopt;
  return FlatBoard{dataset.boards[0].world_from_board, (low + high).head<2>() / 2,
                   size.head<2>() / 2};
}

const ViewProblem& Bundle::bent(const ViewProblem& flat, ViewProblem& buffer) const {
  if (!bent_board) return flat;
  buffer = flat;
  bent_board->bend(buffer, bend_m);
  return buffer;
}

Bundle Bundle::without_views() const {
  return {model, image_size, free_values, {}, {}, bent_board, bend_m};
}

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
  const Eigen::Vector2d start_bend_m = bundle.bend_m;
  Evaluation evaluation(bundle, views, num_threads);
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &evaluation;
  ceres::Problem problem(problem_options);
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  std::vector<double*> common;
  if (bundle.model->num_free() > 0) common.push_back(bundle.free_values.data());
  if (bundle.bent_board) common.push_back(bundle.bend_m.data());
  for (std::size_t i = 0; i < bundle.views.size(); ++i) {
    ViewRows& view = views.emplace_back(bundle, i);
    std::vector<double*> blocks = {view.step.data()};
    blocks.insert(blocks.end(), common.begin(), common.end());
    problem.AddResidualBlock(new ViewCost(view, bundle), nullptr, blocks);
    ordering->AddElementToGroup(view.step.data(), 0);
  }
  for (double* block : common) ordering->AddElementToGroup(block, 1);
  ceres::Solver::Options options = solver_options(max_iterations);
  options.linear_solver_ordering = ordering;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  for (std::size_t i = 0; i < views.size(); ++i)
    bundle.camera_from_target[i] = views[i].pose.at(views[i].step);
  if (bundle.bent_board)
    for (ViewProblem& view : bundle.views)
      bundle.bent_board->bend(view, bundle.bend_m - start_bend_m);
  return {summary.termination_type == ceres::CONVERGENCE, 2 * summary.final_cost,
          static_cast<int>(summary.iterations.size())};
}

}  // namespace tagcal::internal
