// Ceres as the witness: poses and focal lengths of single views are found by a loop of the library
// (refine_pose), and have to be the minimum and the covariance that Ceres finds, with automatic
// derivatives of the lens' formula, dense QR and the covariance by a singular value decomposition.

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <vector>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/pose_hypotheses.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

template <typename T>
void distort(const Perspective& lens, T& x, T& y) {
  const auto p = lens.parameters();
  const T s = x * x + y * y, radial = 1.0 + s * (p[4] + s * (p[5] + s * p[8]));
  const T a = 2.0 * p[6] * x * y + p[7] * (s + 2.0 * x * x);
  const T b = p[6] * (s + 2.0 * y * y) + 2.0 * p[7] * x * y;
  x = x * radial + a;
  y = y * radial + b;
}

template <typename T>
void distort(const Fisheye& lens, T& x, T& y) {
  const auto p = lens.parameters();
  const T r = sqrt(x * x + y * y), angle = atan(r), s = angle * angle;
  const T scale = angle * (1.0 + s * (p[4] + s * (p[5] + s * (p[6] + s * p[7])))) / r;
  x *= scale;
  y *= scale;
}

// The whitened residual of a corner by a step (omega, tau) of `retract` about a pose, and by the
// change of log f.
template <typename LensKind>
struct Residual {
  LensKind lens;
  Pose pose;
  Correspondence seen;
  Matrix2 whitening;

  template <typename T>
  bool operator()(const T* step, const T* log_f, T* residual) const {
    const Vector3d turned = pose.rotation() * seen.point;
    const T from[] = {T(turned.x()), T(turned.y()), T(turned.z())};
    T x[3];
    ceres::AngleAxisRotatePoint(step, from, x);
    for (int i = 0; i < 3; ++i) x[i] += pose.translation()[i] + step[3 + i];
    if (!(x[2] > 0.0)) return false;
    T a = x[0] / x[2], b = x[1] / x[2];
    distort(lens, a, b);
    const auto p = lens.parameters();
    const T u = exp(*log_f) * p[0] * a + p[2] - seen.pixel.x();
    const T v = exp(*log_f) * p[1] * b + p[3] - seen.pixel.y();
    residual[0] = whitening(0, 0) * u + whitening(0, 1) * v;
    residual[1] = whitening(1, 0) * u + whitening(1, 1) * v;
    return true;
  }
};

struct Scene {
  Lens lens;  // for a focal length: with the estimated one
  std::vector<Correspondence> seen;
  std::vector<Matrix2> covariances;
  double sigma_px = 1;
  Pose truth;
};

// A minimum by Ceres.
struct Solution {
  Pose pose;
  double log_f = 0;  // over that of the scene's lens
  double cost = 0;   // of the whitened residuals
  MatrixXd covariance;
};

template <typename LensKind>
class Witness {
 public:
  Witness(const Scene& scene, const LensKind& lens, const Pose& pose, bool with_focal) {
    for (std::size_t i = 0; i < scene.seen.size(); ++i) {
      Matrix2 w = Matrix2::Identity() / scene.sigma_px;
      if (!scene.covariances.empty())
        w = Eigen::Matrix2d(Eigen::LLT<Eigen::Matrix2d>(scene.covariances[i]).matrixL()).inverse();
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<Residual<LensKind>, 2, 6, 1>(
                                    new Residual<LensKind>{lens, pose, scene.seen[i], w}),
                                nullptr, step_, &log_f_);
    }
    if (!with_focal) problem_.SetParameterBlockConstant(&log_f_);
  }

  // Minimises the cost from a step, as far as Ceres sees it decrease. Returns it.
  double minimise(const VectorXd& start, int max_iterations) {
    std::copy_n(start.data(), 6, step_);
    if (start.size() == 7) log_f_ = start[6];
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = max_iterations;
    options.function_tolerance = options.gradient_tolerance = 0;
    options.parameter_tolerance = 1e-14;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return 2 * summary.final_cost;
  }

  MatrixXd covariance(bool with_focal) {
    ceres::Covariance::Options options;
    options.algorithm_type = ceres::DENSE_SVD;
    ceres::Covariance covariance(options);
    std::vector<const double*> blocks = {step_};
    if (with_focal) blocks.push_back(&log_f_);
    MatrixXd c(with_focal ? 7 : 6, with_focal ? 7 : 6);
    if (!covariance.Compute(blocks, &problem_) || !covariance.GetCovarianceMatrix(blocks, c.data()))
      return {};
    return c;
  }

  // A share of the Gauss-Newton step, by Ceres' own gradient and covariance. Returns its predicted
  // decrease of the cost.
  double descend(const MatrixXd& covariance, double share) {
    std::vector<double> gradient;
    problem_.Evaluate({}, nullptr, nullptr, &gradient, nullptr);
    const VectorXd g = VectorXd::Map(gradient.data(), covariance.rows());
    const VectorXd step = -covariance * g;
    for (int i = 0; i < 6; ++i) step_[i] += share * step[i];
    if (step.size() == 7) log_f_ += share * step[6];
    return -step.dot(g);
  }

  Vector6d step() const { return Vector6d::Map(step_); }
  double log_f() const { return log_f_; }

 private:
  ceres::Problem problem_;
  double step_[6] = {}, log_f_ = 0;
};

constexpr int kRounds = 100;

// Ceres' minimum from a pose displaced by a step.
Solution minimum(const Scene& scene, const Pose& pose, const VectorXd& start) {
  const bool with_focal = start.size() == 7;
  return std::visit(
      [&](const auto& lens) -> Solution {
        using LensKind = std::decay_t<decltype(lens)>;
        if constexpr (std::is_same_v<LensKind, Perspective> || std::is_same_v<LensKind, Fisheye>) {
          // Ceres ends where rounding hides that the cost decreases, 1e-6 standard deviations
          // before the minimum, and the covariance belongs to steps from there: the rest is by
          // steps of Gauss and Newton, shorter where they do not converge.
          Solution best{pose, 0, 0, {}};
          VectorXd from = start;
          double share = 1, decrease = std::numeric_limits<double>::infinity();
          for (int round = 0; round < kRounds && decrease > 1e-17; ++round) {
            Witness<LensKind> witness(scene, lens, best.pose, with_focal);
            best.cost = witness.minimise(from, round == 0 ? 200 : 0);
            best.covariance = witness.covariance(with_focal);
            if (round > 0) {
              const double last = std::exchange(decrease, witness.descend(best.covariance, share));
              if (decrease > last) share /= 2;
            }
            best.pose = retract(best.pose, witness.step());
            best.log_f = witness.log_f();
            from.setZero();
            if (with_focal) from[6] = best.log_f;
          }
          return best;
        }
        return {};
      },
      scene.lens);
}

std::vector<Vector3d> some_target(Random& random) {
  const double kind = random.uniform();
  if (kind < 0.3) return tag_points(random.uniform(0.1, 0.4));
  if (kind < 0.6) return points_in_box(5 + int(20 * random.uniform()), 0.3, 1, random);
  return points_in_box(5 + int(20 * random.uniform()), 0.3, 0, random);
}

Scene some_scene(const Lens& lens, Random& random) {
  Scene scene{lens, {}, {}, 0.05 * std::pow(20, random.uniform()), {}};
  scene.truth =
      looking_at_board(Vector3d::Zero(), random.uniform(0, 1.2), random.uniform(0.8, 3), random);
  scene.seen = seen_by(lens, some_target(random), scene.truth, scene.sigma_px, random);
  if (random.uniform() < 0.3)
    for (std::size_t i = 0; i < scene.seen.size(); ++i) {
      const double a = std::exp(0.5 * random.normal()), b = std::exp(0.5 * random.normal());
      Matrix2 c;
      c << a, 0.3 * std::sqrt(a * b), 0.3 * std::sqrt(a * b), b;
      scene.covariances.push_back(scene.sigma_px * scene.sigma_px * c);
    }
  return scene;
}

VectorXd random_step(const MatrixXd& covariance, double sigmas, Random& random) {
  VectorXd direction(covariance.rows());
  for (double& x : direction) x = random.normal();
  const MatrixXd root = covariance.llt().matrixL();
  return sigmas * root * direction.normalized();
}

// The largest differences of all answers from Ceres, and the number of answers. A covariance that
// the profile likelihood widened must not be smaller than that of Ceres.
struct Tally {
  int answers = 0, hypotheses = 0, equal_covariances = 0;
  double distance = 0;    // in standard deviations
  double covariance = 0;  // largest element of the difference over the standard deviations
  double deficit = 0;     // of a widened covariance: how far it is below Ceres', likewise
  double worse_cost = 0;  // sigma^2: by how much Ceres found a better minimum

  void add(const VectorXd& error, const MatrixXd& claimed, const MatrixXd& covariance_there,
           bool may_be_widened) {
    ++hypotheses;
    distance = std::max(distance, std::sqrt(error.dot(covariance_there.ldlt().solve(error))));
    const VectorXd weight = covariance_there.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixXd difference =
        weight.asDiagonal() * (claimed - covariance_there) * weight.asDiagonal();
    if (may_be_widened) {
      const double least =
          Eigen::SelfAdjointEigenSolver<MatrixXd>(difference).eigenvalues().minCoeff();
      deficit = std::max(deficit, -least);
    } else {
      ++equal_covariances;
      covariance = std::max(covariance, difference.cwiseAbs().maxCoeff());
    }
  }

  void expect_equal() const {
    constexpr double kEqual = 1e-6;
    EXPECT_LT(distance, kEqual);
    EXPECT_LT(covariance, kEqual);
    EXPECT_LT(deficit, kEqual);
    EXPECT_LT(worse_cost, kEqual);
  }
};

constexpr int kViews = 5000;

// A covariance for the stated noise, or the larger one that the residuals show.
MatrixXd scaled(const MatrixXd& covariance, double sigma_px, const Scene& scene) {
  const double ratio = sigma_px / (scene.covariances.empty() ? scene.sigma_px : 1);
  return ratio * ratio * covariance;
}

TEST(CeresWitness, PosesAreCeresOwnMinimumWithItsCovariance) {
  Random random(42);
  Tally tally;
  const Lens lenses[] = {centred_pinhole(900), opencv5_lens(), fisheye_lens()};
  for (int i = 0; i < kViews; ++i) {
    Scene scene = some_scene(lenses[i % 3], random);
    PoseOptions options;
    options.sigma_px = scene.covariances.empty() ? scene.sigma_px : 0;
    options.covariance_px2 = scene.covariances;
    options.reject_outliers = false;
    const PoseEstimate found = estimate_pose(scene.seen, {scene.lens, {1280, 800}}, options);
    if (!is_answer(found.status)) continue;
    ++tally.answers;
    double best_cost = std::numeric_limits<double>::infinity();
    for (const PoseHypothesis& h : found.hypotheses) {
      const Solution there =
          minimum(scene, h.camera_from_target, random_step(h.covariance, 0.1, random));
      best_cost = std::min(best_cost, there.cost);
      const MatrixXd c = scaled(there.covariance, found.sigma_px, scene);
      const Eigen::Vector3d turns =
          Eigen::SelfAdjointEigenSolver<MatrixXd>(c.topLeftCorner<3, 3>()).eigenvalues();
      tally.add(minus(h.camera_from_target, there.pose), h.covariance, c,
                turns[2] > 0.999 * internal::kCurved * std::sqrt(turns[0]));
    }
    const Solution from_truth = minimum(scene, scene.truth, Vector6d::Zero());
    tally.worse_cost = std::max(tally.worse_cost, best_cost - from_truth.cost);
  }
  tally.expect_equal();
  EXPECT_GT(tally.answers, kViews * 97 / 100);
  EXPECT_GT(tally.equal_covariances, kViews * 7 / 10);
}

TEST(CeresWitness, FocalLengthsAreCeresOwnMinimumWithItsCovariance) {
  Random random(43);
  Tally tally;
  for (int i = 0; i < kViews; ++i) {
    const double focal_px = random.uniform(600, 1500);
    Scene scene = some_scene(centred_pinhole(focal_px), random);
    PoseAndFocalOptions options;
    options.exact_pinhole = true;
    options.sigma_px = scene.covariances.empty() ? scene.sigma_px : 0;
    options.covariance_px2 = scene.covariances;
    options.reject_outliers = false;
    const PoseAndFocalEstimate found = estimate_pose_and_focal(scene.seen, {1280, 800}, options);
    if (!is_answer(found.status)) continue;
    ++tally.answers;
    scene.lens = centred_pinhole(found.focal_px);
    const Solution there =
        minimum(scene, found.camera_from_target(), random_step(found.covariance, 0.3, random));
    VectorXd error(7);
    error << minus(found.camera_from_target(), there.pose), -there.log_f;
    const MatrixXd c = scaled(there.covariance, found.sigma_px, scene);
    tally.add(error, found.covariance, c,
              std::sqrt(c(6, 6)) > 0.999 * internal::policy::kFocalWellKnown);
    VectorXd from_truth = VectorXd::Zero(7);
    from_truth[6] = std::log(focal_px / found.focal_px);
    tally.worse_cost =
        std::max(tally.worse_cost, there.cost - minimum(scene, scene.truth, from_truth).cost);
  }
  tally.expect_equal();
  EXPECT_GT(tally.answers, kViews / 2);
  EXPECT_GT(tally.equal_covariances, kViews / 4);
}

}  // namespace
}  // namespace tagcal
