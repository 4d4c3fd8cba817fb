#include "tagcal/estimate/refine.hpp"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <array>
#include <memory>
#include <mutex>

#include "tagcal/estimate/view_solver.hpp"

namespace tagcal {
namespace {

// The length in which a pose's translation steps are counted: its distance, so that rotations and
// translations are alike for the solver and no unit of length is special.
PoseStep step_about(const Pose& pose) {
  const double distance = pose.translation().norm();
  return {pose, distance > 0 ? distance : 1.0};
}

// The lens of the parameters that Ceres tries, made once per trial and not once per view.
class SharedLens {
 public:
  SharedLens(const Model& model, const ImageSize& size) : model_(model), size_(size) {}

  const Lens* at(const double* values) {
    const std::vector<double> wanted(values, values + model_.num_free());
    if (wanted != values_ || !tried_) {
      values_ = wanted;
      lens_ = model_.lens(values_, size_);
      tried_ = true;
    }
    return lens_ ? &*lens_ : nullptr;
  }
  const Model& model() const { return model_; }

 private:
  const Model& model_;
  ImageSize size_;
  std::vector<double> values_;
  std::optional<Lens> lens_;
  bool tried_ = false;
};

// All corners of one view: parameter blocks are the pose step (6) and the free parameters (k).
class ViewCost : public ceres::CostFunction {
 public:
  ViewCost(const ViewProblem& view, const PoseStep& pose, SharedLens& lens)
      : view_(view), pose_(pose), lens_(lens) {
    set_num_residuals(2 * static_cast<int>(view.correspondences.size()));
    mutable_parameter_block_sizes()->push_back(6);
    if (lens.model().num_free() > 0)
      mutable_parameter_block_sizes()->push_back(lens.model().num_free());
  }

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    const int k = lens_.model().num_free();
    const Lens* lens = lens_.at(k > 0 ? parameters[1] : nullptr);
    if (!lens) return false;
    Eigen::Map<RowMajor6> by_step(jacobians ? jacobians[0] : nullptr, num_residuals(), 6);
    Eigen::Map<RowMajorX> by_parameters(jacobians && k > 0 ? jacobians[1] : nullptr,
                                        num_residuals(), k);
    ReprojectionOutput output{Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()),
                              by_step.data() ? &by_step : nullptr,
                              by_parameters.data() ? &by_parameters : nullptr};
    return reprojection(view_, *lens, lens_.model().free(), pose_,
                        Eigen::Map<const Vector6d>(parameters[0]), output);
  }

 private:
  const ViewProblem& view_;
  const PoseStep& pose_;
  SharedLens& lens_;
};

// Ceres prints through glog when an evaluation fails, whatever its own options say.
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
  options.function_tolerance = 1e-12;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

std::optional<RefinedPose> refine_pose(const ViewProblem& view, const Lens& lens, const Pose& start,
                                       int max_iterations) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> pixels;
  for (const Correspondence& c : view.correspondences) {
    points.push_back(c.point);
    pixels.push_back(c.pixel);
  }
  ViewSums sums(lens, {points, pixels, view.whitening});
  const auto solution = solve_view<6>(sums, {state_of(start)}, {max_iterations});
  if (!solution) return std::nullopt;
  return RefinedPose{pose_of(solution->state), solution->cost, solution->converged};
}

BundleSummary solve(Bundle& bundle, int max_iterations) {
  silence_logging();
  const std::size_t n = bundle.views.size();
  std::vector<PoseStep> poses(n);
  std::vector<std::array<double, 6>> steps(n, std::array<double, 6>{});
  SharedLens lens(*bundle.model, bundle.image_size);
  ceres::Problem problem;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  const bool has_intrinsics = !bundle.free_values.empty();
  for (std::size_t i = 0; i < n; ++i) {
    poses[i] = step_about(bundle.camera_from_target[i]);
    std::vector<double*> blocks = {steps[i].data()};
    if (has_intrinsics) blocks.push_back(bundle.free_values.data());
    problem.AddResidualBlock(new ViewCost(bundle.views[i], poses[i], lens), nullptr, blocks);
    ordering->AddElementToGroup(steps[i].data(), 0);
  }
  if (has_intrinsics) ordering->AddElementToGroup(bundle.free_values.data(), 1);
  ceres::Solver::Options options = solver_options(max_iterations);
  options.linear_solver_ordering = ordering;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  for (std::size_t i = 0; i < n; ++i)
    bundle.camera_from_target[i] = poses[i].at(Eigen::Map<const Vector6d>(steps[i].data()));
  return {summary.termination_type == ceres::CONVERGENCE, 2 * summary.final_cost,
          static_cast<int>(summary.iterations.size())};
}

}  // namespace tagcal
