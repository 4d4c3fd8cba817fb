#include "tagcal/estimate/bundle/bundle_adjustment.hpp"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <Eigen/LU>
#include <cmath>
#include <memory>
#include <mutex>

#include "tagcal/estimate/bundle/bundle_costs.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/refine_pose.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal::internal {
namespace {

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

namespace {

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
