#include "tagcal/estimate/bundle/bundle_adjustment.hpp"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <Eigen/LU>
#include <cmath>
#include <memory>
#include <mutex>

#include "tagcal/estimate/bundle/varied_poses.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/refine_pose.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal::internal {
namespace {

// The compressed rows [J | r] of a view at the solver's current state. It holds nothing per corner:
// of ten thousand views that would be most of the memory.
struct ViewRows {
  std::size_t camera, view;  // of its bundle
  LinkedPoses::Link link;
  bool valid = false;  // no corner is outside of the lens' domain
  Eigen::MatrixXd rows;

  // Computes the rows for a lens and the shape of the bundle's board.
  void evaluate(const Bundle& bundle, const Lens& lens, const LinkedPoses& poses) {
    ViewEquations equations(bundle, view, bundle.model->free(), bundle.row_prior(view));
    Eigen::MatrixXd gram;
    valid = equations.sums.at(lens, poses.camera_from_board(camera, link), gram);
    if (valid) compressed_rows(gram, 6, rows);
  }
};

// The cost of all corners of one view; parameter blocks are the steps (6 each) of the instant, of a
// camera that is not the reference and of a board that is not the held one, the free parameters and
// the shape of the board (k together). Ceres gets 6 + k + 1 rows instead of two per corner, because
// copying those took most of its time.
class ViewCost : public ceres::CostFunction {
 public:
  ViewCost(const ViewRows& view, const Bundle& bundle, const VariedPoses& poses)
      : view_(view), poses_(poses) {
    set_num_residuals(6 + bundle.num_parameters() + 1);
    parts_.push_back(&poses.instants[view.link.instant]);
    if (moves_camera()) parts_.push_back(&poses.cameras[view.camera]);
    if (moves_board()) parts_.push_back(&poses.boards[view.link.board]);
    for (std::size_t i = 0; i < parts_.size(); ++i) mutable_parameter_block_sizes()->push_back(6);
    const int num_free = bundle.model->num_free();
    if (num_free > 0) mutable_parameter_block_sizes()->push_back(num_free);
    if (bundle.board) mutable_parameter_block_sizes()->push_back(bundle.num_shapes());
  }

  bool Evaluate(const double* const* /*parameters*/, double* residuals,
                double** jacobians) const override {
    if (!view_.valid) return false;
    const Eigen::MatrixXd& rows = view_.rows;
    const Eigen::Index n = rows.rows();
    Eigen::Map<Eigen::VectorXd>(residuals, n) = rows.col(n - 1);
    if (!jacobians) return true;
    set_poses(jacobians);
    Eigen::Index column = 6;
    for (std::size_t b = parts_.size(); b < parameter_block_sizes().size(); ++b) {
      const int k = parameter_block_sizes()[b];
      if (jacobians[b]) Eigen::Map<RowMajorX>(jacobians[b], n, k) = rows.middleCols(column, k);
      column += k;
    }
    return true;
  }

 private:
  bool moves_camera() const { return view_.camera != poses_.values.reference; }
  bool moves_board() const { return view_.link.board != poses_.values.first_board; }

  void set_poses(double** jacobians) const {
    const Eigen::MatrixXd& rows = view_.rows;
    const auto set = [&](std::size_t part, const auto& by_pose) {
      if (!jacobians[part]) return;
      Eigen::Map<RowMajor6> by_step(jacobians[part], rows.rows(), 6);
      parts_[part]->by_step(by_pose, by_step);
    };
    if (parts_.size() == 1 && poses_.values.camera_from_rig.size() == 1)
      return set(0, rows.leftCols<6>());
    const LinkedSteps steps(poses_.values, view_.camera, view_.link);
    const auto by = [&](const Matrix6& step) { return RowMajor6(rows.leftCols<6>() * step); };
    std::size_t part = 0;
    set(part++, by(steps.by_instant));
    if (moves_camera()) set(part++, by(steps.by_camera));
    if (moves_board()) set(part++, by(steps.by_board));
  }

  const ViewRows& view_;
  const VariedPoses& poses_;
  std::vector<const VariedPose*> parts_;  // in the order of the parameter blocks
};

// The cost of the priors; parameter blocks are the free parameters and the shape of the board. With
// several cameras the first one has the board's.
class PriorCost : public ceres::CostFunction {
 public:
  PriorCost(const Bundle& bundle, bool with_board) : bundle_(bundle), with_board_(with_board) {
    set_num_residuals(static_cast<int>(prior().residuals.size()));
    if (bundle.model->num_free() > 0)
      mutable_parameter_block_sizes()->push_back(bundle.model->num_free());
    if (with_board) mutable_parameter_block_sizes()->push_back(bundle.num_shapes());
  }

  // The parameters are those of the bundle.
  bool Evaluate(const double* const* /*parameters*/, double* residuals,
                double** jacobians) const override {
    if (!bundle_.model->lens(bundle_.free_values, bundle_.image_size)) return false;
    const PriorRows rows = prior();
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
  PriorRows prior() const { return with_board_ ? prior_of(bundle_) : prior_of_lens(bundle_); }

  const Bundle& bundle_;
  bool with_board_;
};

// Computes the poses, the lenses and the rows of all views once for each new state of the solver.
// (Ceres asks for the cost there first, and for the Jacobian if it accepts the step.)
class Evaluation : public ceres::EvaluationCallback {
 public:
  Evaluation(std::span<Bundle> cameras, VariedPoses& poses, std::vector<ViewRows>& views,
             std::size_t num_threads)
      : cameras_(cameras), poses_(poses), views_(views), num_threads_(num_threads) {}

  void PrepareForEvaluation(bool /*jacobians*/, bool is_new_point) override {
    if (!is_new_point) return;
    poses_.update();
    std::vector<std::optional<Lens>> lenses;
    for (Bundle& camera : cameras_) {
      lenses.push_back(camera.model->lens(camera.free_values, camera.image_size));
      camera.shape = cameras_.front().shape;
    }
    parallel_for(views_.size(), threads_for_short_calls(views_.size(), num_threads_),
                 [&](std::size_t i) {
                   ViewRows& view = views_[i];
                   view.valid = false;
                   if (const std::optional<Lens>& lens = lenses[view.camera])
                     view.evaluate(cameras_[view.camera], *lens, poses_.values);
                 });
  }

 private:
  std::span<Bundle> cameras_;
  VariedPoses& poses_;
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

// Sets the row terms that are best at the state, and the data's part of the cost.
void set_row_terms(Bundle& bundle, BundleSummary& summary, std::size_t num_threads) {
  const std::size_t n = bundle.views.size();
  const auto lens = bundle.model->lens(bundle.free_values, bundle.image_size);
  std::vector<Vector6d> terms(n, Vector6d::Zero());
  std::vector<double> volumes(n), squares(n);
  if (lens && bundle.row_sigma > 0)
    parallel_for(n, threads_for_short_calls(n, num_threads), [&](std::size_t v) {
      const ViewRowTerms prior = bundle.row_prior(v);
      ViewEquations equations(bundle, v, {}, prior);
      Eigen::MatrixXd gram;
      const Pose& pose = bundle.camera_from_target[v];
      if (!equations.sums.at(*lens, pose, gram)) return;
      terms[v] = equations.sums.row_terms();
      squares[v] = terms[v].squaredNorm() / (prior.sigma * prior.sigma);
      if (bundle.is_rolling())
        terms[v] = moved_twist(pose.inverse(), terms[v].cwiseProduct(bundle.twist_unit()));
      Eigen::MatrixXd volume =
          prior.sigma * prior.sigma * equations.sums.row_equations().information;
      volume.diagonal().array() += 1;
      volumes[v] = std::log(std::max(1.0, volume.determinant()));
    });
  for (std::size_t v = 0; v < n; ++v) {
    summary.row_volume += volumes[v];
    summary.prior += squares[v];
  }
  bundle.row_terms = std::move(terms);
}

// The parameters that views have in common: those of each camera, then those of the boards.
std::vector<double*> common_blocks(std::span<Bundle> cameras, VariedPoses& poses) {
  std::vector<double*> blocks;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (cameras[c].model->num_free() > 0) blocks.push_back(cameras[c].free_values.data());
    if (c != poses.values.reference && !cameras[c].views.empty())
      blocks.push_back(poses.cameras[c].step.data());
  }
  for (std::size_t b = 0; b < poses.boards.size(); ++b)
    if (b != poses.values.first_board) blocks.push_back(poses.boards[b].step.data());
  if (cameras.front().board) blocks.push_back(cameras.front().shape.data());
  return blocks;
}

void add_views(std::span<Bundle> cameras, VariedPoses& poses, std::vector<ViewRows>& views,
               ceres::Problem& problem) {
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    Bundle& camera = cameras[c];
    for (std::size_t v = 0; v < camera.views.size(); ++v) {
      const LinkedPoses::Link link = poses.values.links[c][v];
      ViewRows& view = views.emplace_back(ViewRows{c, v, link, false, {}});
      std::vector<double*> blocks = {poses.instants[link.instant].step.data()};
      if (c != poses.values.reference) blocks.push_back(poses.cameras[c].step.data());
      if (link.board != poses.values.first_board)
        blocks.push_back(poses.boards[link.board].step.data());
      if (camera.model->num_free() > 0) blocks.push_back(camera.free_values.data());
      if (camera.board) blocks.push_back(cameras.front().shape.data());
      problem.AddResidualBlock(new ViewCost(view, camera, poses), nullptr, blocks);
    }
  }
}

void add_priors(std::span<Bundle> cameras, ceres::Problem& problem) {
  for (Bundle& camera : cameras) {
    std::vector<double*> blocks;
    if (camera.model->num_free() > 0) blocks.push_back(camera.free_values.data());
    const bool with_board = &camera == &cameras.front() && camera.board;
    if (with_board) blocks.push_back(camera.shape.data());
    if (!blocks.empty())
      problem.AddResidualBlock(new PriorCost(camera, with_board), nullptr, blocks);
  }
}

// Instants first. Each common block has a group of its own: within one, the order is that of the
// addresses, and those of heap and stack differ between threads.
std::shared_ptr<ceres::ParameterBlockOrdering> ordering_of(VariedPoses& poses,
                                                           const std::vector<double*>& common,
                                                           const ceres::Problem& problem) {
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (VariedPose& instant : poses.instants)
    if (problem.HasParameterBlock(instant.step.data()))
      ordering->AddElementToGroup(instant.step.data(), 0);
  int group = 0;
  for (double* block : common)
    if (problem.HasParameterBlock(block)) ordering->AddElementToGroup(block, ++group);
  return ordering;
}

}  // namespace

BundleSummary solve(std::span<Bundle> cameras, LinkedPoses& poses, int max_iterations,
                    std::size_t num_threads) {
  silence_logging();
  VariedPoses varied(poses);
  std::vector<ViewRows> views;
  std::size_t num_views = 0;
  for (const Bundle& camera : cameras) num_views += camera.views.size();
  views.reserve(num_views);
  Evaluation evaluation(cameras, varied, views, num_threads);
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &evaluation;
  ceres::Problem problem(problem_options);
  add_views(cameras, varied, views, problem);
  add_priors(cameras, problem);
  ceres::Solver::Options options = solver_options(max_iterations);
  options.linear_solver_ordering = ordering_of(varied, common_blocks(cameras, varied), problem);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  varied.update();
  BundleSummary result;
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  result.num_iterations = static_cast<int>(summary.iterations.size());
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    Bundle& camera = cameras[c];
    camera.shape = cameras.front().shape;
    for (std::size_t v = 0; v < camera.views.size(); ++v)
      camera.camera_from_target[v] = poses.camera_from_board(c, poses.links[c][v]);
    const PriorRows prior = c == 0 ? prior_of(camera) : prior_of_lens(camera);
    result.prior += camera.sigma * camera.sigma * prior.residuals.squaredNorm();
    set_row_terms(camera, result, num_threads);
  }
  result.cost = std::max(0.0, 2 * summary.final_cost - result.prior);
  return result;
}

BundleSummary solve(Bundle& bundle, int max_iterations, std::size_t num_threads) {
  LinkedPoses poses{{Pose()}, bundle.camera_from_target, {Pose()}, 0, 0, {{}}};
  for (std::size_t i = 0; i < bundle.views.size(); ++i) poses.links[0].push_back({i, 0, {}});
  return solve({&bundle, 1}, poses, max_iterations, num_threads);
}

}  // namespace tagcal::internal
