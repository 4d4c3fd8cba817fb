#include "tagcal/estimate/bundle/covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/profile_likelihood.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kMostDirections = 1000;

// Index of the focal length or coordinate of the principal point with the largest variance; -1 if
// none is free.
Index least_known_parameter(const Model& model, const MatrixXd& covariance) {
  Index least = -1;
  for (Index i = 0; i < model.num_free(); ++i) {
    const ParameterKind kind = model.free()[static_cast<std::size_t>(i)].kind();
    const bool is_pinhole =
        kind == ParameterKind::focal_length || kind == ParameterKind::principal_point;
    if (is_pinhole && (least < 0 || covariance(i, i) > covariance(least, least))) least = i;
  }
  return least;
}

// The likelihood of the free parameters of a bundle: the best poses belong to them.
class BundleLikelihood {
 public:
  struct State {
    std::vector<double> free_values;
    std::vector<Pose> poses;
  };
  using Step = VectorXd;
  using Matrix = MatrixXd;
  struct Equations {
    MatrixXd information;
    VectorXd gradient;
    double cost = 0;
  };
  struct Solver {
    bool compute(const MatrixXd& information) {
      inverse = exact_inverse(information);
      return inverse.has_value();
    }
    VectorXd solve(const VectorXd& b) const { return *inverse * b; }

    std::optional<MatrixXd> inverse;
  };

  BundleLikelihood(const Bundle& solved, const BundleInformation& information)
      : bundle_(solved), information_(information) {}

  static int rounds() { return 4; }

  bool at(State& state, Equations& equations) {
    bundle_.free_values = state.free_values;
    bundle_.camera_from_target = state.poses;
    const auto lens = bundle_.model->lens(bundle_.free_values, bundle_.image_size);
    if (!lens) return false;
    equations.cost = 0;
    for (std::size_t v = 0; v < bundle_.views.size(); ++v) {
      const auto refined = refine_view_pose(bundle_.views[v], *lens, state.poses[v]);
      if (!refined) return false;
      state.poses[v] = bundle_.camera_from_target[v] = refined->camera_from_target;
      equations.cost += refined->cost;
    }
    const auto information = bundle_information(bundle_);
    if (!information) return false;
    // A bend of the board is held.
    const Index k = bundle_.model->num_free();
    equations.information = information->sum().topLeftCorner(k, k);
    equations.gradient = information->gradient().head(k);
    return true;
  }

  State stepped(const State& state, const VectorXd& step) const {
    State next = state;
    Eigen::Map<VectorXd>(next.free_values.data(), step.size()) += step;
    for (std::size_t v = 0; v < next.poses.size(); ++v)
      next.poses[v] =
          retract(state.poses[v], -information_.pose_by_parameters[v].leftCols(step.size()) * step);
    return next;
  }

 private:
  Bundle bundle_;
  const BundleInformation& information_;  // of the solved bundle
};

}  // namespace

std::optional<MatrixXd> exact_inverse(const MatrixXd& information) {
  const VectorXd diagonal = information.diagonal();
  if (!(diagonal.array() > 0).all() || !information.allFinite()) return std::nullopt;
  const VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
  const MatrixXd unit = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::LDLT<MatrixXd> ldlt(unit);
  constexpr double kRounding = 1e-15;  // numeric: a few times that of a double
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().array() > kRounding).all())
    return std::nullopt;
  const MatrixXd inverse = ldlt.solve(MatrixXd::Identity(unit.rows(), unit.cols()));
  return MatrixXd(scale.asDiagonal() * inverse * scale.asDiagonal());
}

std::optional<ViewInformation> information_of(const ViewProblem& view, const Lens& lens,
                                              std::span<const FreeParameter> free,
                                              const Pose& camera_from_target,
                                              const FlatBoard* board) {
  const ViewArrays arrays(view);
  const BoardShapes bends = board ? board->shapes(arrays.view().points) : BoardShapes{};
  ParameterSums sums(arrays.view(), free, bends.view());
  MatrixXd gram, rows;
  if (!sums.at(lens, camera_from_target, gram)) return std::nullopt;
  const Index n = gram.cols() - 7;
  const Matrix6 by_pose = gram.topLeftCorner<6, 6>().selfadjointView<Eigen::Upper>();
  const std::optional<MatrixXd> inverse = exact_inverse(by_pose);
  if (!inverse) return std::nullopt;
  // Triangular rows [J | r] with the same products. The rows below those of the pose are free of
  // it; S as their square stays positive semidefinite, which a difference would not.
  compressed_rows(gram, rows);
  const auto rest = rows.bottomRows(n + 1).rightCols(n + 1);
  ViewInformation result;
  result.pose_inverse = *inverse;
  result.pose_by_parameters = *inverse * gram.block(0, 6, 6, n);
  result.schur = rest.leftCols(n).transpose() * rest.leftCols(n);
  result.gradient = rest.leftCols(n).transpose() * rest.col(n);
  return result;
}

void BundleInformation::raise_unobservable() {
  halves[0].diagonal() += policy::kUnobservablePrecision * sum().diagonal();
}

std::optional<BundleInformation> bundle_information(const Bundle& bundle,
                                                    const FlatBoard* held_flat) {
  const Lens lens = bundle.lens();
  const FlatBoard* board = bundle.bent_board ? &*bundle.bent_board : held_flat;
  const Index n = bundle.model->num_free() + (board ? 2 : 0);
  BundleInformation result;
  result.halves.fill(MatrixXd::Zero(n, n));
  result.gradients.fill(VectorXd::Zero(n));
  for (std::size_t i = 0; i < bundle.views.size(); ++i) {
    auto view = information_of(bundle.views[i], lens, bundle.model->free(),
                               bundle.camera_from_target[i], board);
    if (!view) return std::nullopt;
    result.halves[i % 2] += view->schur;
    result.gradients[i % 2] += view->gradient;
    result.pose_inverse.push_back(view->pose_inverse);
    result.pose_by_parameters.push_back(std::move(view->pose_by_parameters));
  }
  return result;
}

std::optional<BundleCovariance> covariance_of(const Bundle& bundle, double sigma) {
  const auto information = bundle_information(bundle);
  if (!information) return std::nullopt;
  return covariance_of(bundle, *information, sigma);
}

std::optional<BundleCovariance> covariance_of(const Bundle& bundle,
                                              const BundleInformation& information, double sigma) {
  BundleCovariance covariance;
  const double square = sigma * sigma;
  const Index k = bundle.num_parameters();
  if (k > 0) {
    const MatrixXd schur = information.sum().topLeftCorner(k, k);
    const std::optional<MatrixXd> inverse = exact_inverse(schur);
    if (!inverse) return std::nullopt;
    covariance.parameters = square * *inverse;
    const VectorXd gradient = information.gradient().head(k) / square;
    covariance.decrement = gradient.dot(covariance.parameters * gradient);
  }
  for (std::size_t i = 0; i < information.pose_inverse.size(); ++i) {
    MatrixXd c = square * information.pose_inverse[i];
    const MatrixXd by_parameters = information.pose_by_parameters[i].leftCols(k);
    if (k > 0) c += by_parameters * covariance.parameters * by_parameters.transpose();
    covariance.poses.emplace_back(c);
  }
  const Index of_lens = bundle.model->num_free();
  covariance.parameters.conservativeResize(of_lens, of_lens);
  return covariance;
}

MatrixXd profile_covariance(const Bundle& solved, const BundleInformation& information,
                            const MatrixXd& covariance, double sigma) {
  const Index least = least_known_parameter(*solved.model, covariance);
  if (least < 0) return covariance;
  const double sigma_px = std::sqrt(covariance(least, least));
  const Lens lens = solved.lens();
  if (!(sigma_px > policy::kLinearShare * parameters(lens)[0])) return covariance;
  const Index k = covariance.cols();
  const MatrixXd schur = information.sum().topLeftCorner(k, k);
  const BundleLikelihood::State best{solved.free_values, solved.camera_from_target};
  BundleLikelihood likelihood(solved, information);
  ProfileLikelihood<BundleLikelihood> profile(likelihood, best, cost_of(solved), sigma,
                                              schur / (sigma * sigma), covariance);
  const VectorXd function = VectorXd::Unit(k, least) / sigma_px;
  for (const double level : {policy::kProfileBundleSigmas, -policy::kProfileBundleSigmas})
    profile.widen({function, covariance * function}, level, policy::kProfileBundleSigmas);
  return profile.covariance();
}

std::optional<BoardWarp> board_warp(const Bundle& bundle, const BundleInformation& information,
                                    double sigma) {
  const auto inverse = exact_inverse(information.sum());
  if (!inverse) return std::nullopt;
  const Eigen::Vector2d bend_m = bundle.bend_m - (*inverse * information.gradient()).tail<2>();
  const Eigen::Matrix2d covariance = sigma * sigma * inverse->bottomRightCorner<2, 2>();
  const auto weight = exact_inverse(covariance);
  if (!weight) return std::nullopt;
  BoardWarp warp;
  warp.bend_mm = 1e3 * bend_m;
  warp.sigma_mm = 1e3 * covariance.diagonal().cwiseSqrt();
  warp.chi_square = bend_m.dot(*weight * bend_m);
  return warp;
}

double projection_sigma_at_infinity_px(const Bundle& bundle, const MatrixXd& covariance) {
  // One "view" of the directions to the corners, at unit distance.
  const Lens lens = bundle.lens();
  std::vector<Vector3d> directions;
  std::size_t count = 0, all = 0;
  for (const ViewProblem& view : bundle.views) all += view.correspondences.size();
  const std::size_t stride = 1 + all / kMostDirections;
  for (std::size_t i = 0; i < bundle.views.size(); ++i)
    for (const Correspondence& c : bundle.views[i].correspondences)
      if (count++ % stride == 0)
        directions.push_back((bundle.camera_from_target[i] * c.point).normalized());
  // There are no observed pixels: the sums with the residual are not used.
  const std::vector<Eigen::Vector2d> pixels(directions.size(), Eigen::Vector2d::Zero());
  ParameterSums sums({directions, pixels}, bundle.model->free());
  MatrixXd gram;
  if (!sums.at(lens, Pose(), gram)) return std::numeric_limits<double>::infinity();
  const Index k = covariance.cols();
  MatrixXd by_turn_and_parameters(3 + k, 3 + k), rows;
  by_turn_and_parameters << gram.topLeftCorner(3, 3), gram.block(0, 6, 3, k), MatrixXd::Zero(k, 3),
      gram.block(6, 6, k, k);
  compressed_rows(by_turn_and_parameters, rows);
  const MatrixXd rest = rows.bottomRightCorner(k, k);
  const double trace = (rest * covariance).cwiseProduct(rest).sum();
  return std::sqrt(std::max(0.0, trace) / static_cast<double>(2 * directions.size()));
}

}  // namespace tagcal::internal
