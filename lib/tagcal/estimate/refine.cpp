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

// A view's correspondences as the kernels take them.
class ViewArrays {
 public:
  explicit ViewArrays(const ViewProblem& view) : whitening_(view.whitening) {
    for (const Correspondence& c : view.correspondences) {
      points_.push_back(c.point);
      pixels_.push_back(c.pixel);
    }
  }
  ViewPoints view() const { return {points_, pixels_, whitening_}; }

 private:
  std::vector<Eigen::Vector3d> points_;
  std::vector<Eigen::Vector2d> pixels_;
  std::span<const Matrix2> whitening_;
};

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
      ++generation_;
    }
    return lens_ ? &*lens_ : nullptr;
  }
  const Model& model() const { return model_; }
  long generation() const { return generation_; }  // of the lens: another one has another number

 private:
  const Model& model_;
  ImageSize size_;
  long generation_ = 0;
  std::vector<double> values_;
  std::optional<Lens> lens_;
  bool tried_ = false;
};

// R with R'R = the gram matrix of rows [J | r], upper triangular: the same cost, gradient and J'J
// in as many rows as there are columns. A column that depends on those before it leaves a row of
// zeros.
Eigen::MatrixXd compressed_rows(const Eigen::MatrixXd& gram) {
  constexpr double kRounding = 1e-14;
  const Eigen::Index n = gram.cols();
  Eigen::MatrixXd r = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double pivot = gram(i, i) - r.col(i).head(i).squaredNorm();
    if (!(pivot > kRounding * gram(i, i))) continue;
    r(i, i) = std::sqrt(pivot);
    for (Eigen::Index j = i + 1; j < n; ++j)
      r(i, j) = (gram(i, j) - r.col(i).head(i).dot(r.col(j).head(i))) / r(i, i);
  }
  return r;
}

// All corners of one view: parameter blocks are the pose step (6) and the free parameters (k).
// Ceres gets 6 + k + 1 rows instead of two a corner: moving those about took it most of its time.
class ViewCost : public ceres::CostFunction {
 public:
  ViewCost(const ViewProblem& view, const PoseStep& pose, SharedLens& lens)
      : arrays_(view), pose_(pose), lens_(lens), sums_(arrays_.view(), lens.model().free()) {
    set_num_residuals(static_cast<int>(sums_.num_columns()));
    mutable_parameter_block_sizes()->push_back(6);
    if (lens.model().num_free() > 0)
      mutable_parameter_block_sizes()->push_back(lens.model().num_free());
  }

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    const int k = lens_.model().num_free();
    if (!find_rows(Eigen::Map<const Vector6d>(parameters[0]), k > 0 ? parameters[1] : nullptr))
      return false;
    const Eigen::Index n = sums_.num_columns();
    Eigen::Map<Eigen::VectorXd>(residuals, n) = rows_.col(n - 1);
    if (jacobians && jacobians[0]) {
      Eigen::Map<RowMajor6> by_step(jacobians[0], n, 6);
      by_step.leftCols<3>() = rows_.leftCols<3>() * left_jacobian(step_.head<3>());
      by_step.rightCols<3>() = pose_.length * rows_.middleCols<3>(3);
    }
    if (jacobians && k > 0 && jacobians[1])
      Eigen::Map<RowMajorX>(jacobians[1], n, k) = rows_.middleCols(6, k);
    return true;
  }

 private:
  // Ceres asks for the cost first, and for the Jacobian of the same point if it takes the step.
  bool find_rows(const Vector6d& step, const double* free_values) const {
    const Lens* lens = lens_.at(free_values);
    if (!lens) return false;
    if (has_rows_ && step == step_ && lens_.generation() == generation_) return true;
    has_rows_ = sums_.at(*lens, pose_.at(step), gram_);
    if (!has_rows_) return false;
    rows_ = compressed_rows(gram_);
    step_ = step;
    generation_ = lens_.generation();
    return true;
  }

  const ViewArrays arrays_;
  const PoseStep& pose_;
  SharedLens& lens_;
  mutable ParameterSums sums_;
  mutable Eigen::MatrixXd gram_, rows_;
  mutable Vector6d step_ = Vector6d::Zero();
  mutable long generation_ = -1;
  mutable bool has_rows_ = false;
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
  const ViewArrays arrays(view);
  ViewSums sums(lens, arrays.view());
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
