#include "tagcal/estimate/handeye/handeye_bundle.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tagcal/estimate/policy/handeye_policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::MatrixXd;
using Square6 = Eigen::Matrix<double, 6, 6>;

double log_det(const auto& llt) { return 2 * llt.matrixLLT().diagonal().array().log().sum(); }

// Weights of the wide priors of the shared parameters: translations about zero. (Rotations have
// none: theirs is a damping.) The offset of time has none, and a unit weight if it is not free. The
// logarithm of the board's scale has its own.
HandeyeEquations::Shared prior_weights(const HandeyeProblem& problem) {
  const double reach = policy::kPriorReach * problem.scale.distance_m;
  HandeyeEquations::Shared weights;
  weights[HandeyeEquations::kTime] = problem.with_time ? 0 : 1;
  weights[HandeyeEquations::kScale] = 1 / (problem.board_scale_sigma * problem.board_scale_sigma);
  for (Eigen::Index i = 0; i < 12; ++i)
    weights[i] = 1 / (i % 6 < 3 ? std::numbers::pi * std::numbers::pi : reach * reach);
  return weights;
}

// (value - prior) / sd, squared.
double noise_prior(const RobotNoise& noise) {
  const double rad = std::log(noise.sigma_rad / policy::kPriorRobotRad) / policy::kPriorLogRobot;
  const double m = std::log(noise.sigma_m / policy::kPriorRobotM) / policy::kPriorLogRobot;
  return rad * rad + m * m;
}

// Holds the camera's translation in directions u of a larger standard deviation. With u's = 0 the
// best step is s - C u (u's) / (u'C u), which lowers the cost by (u's)^2 / (u'C u) less.
void hold_step(double most_m, HandeyeEquations::Solution& solution) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(
      solution.covariance.block<3, 3>(3, 3));
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double variance = principal.eigenvalues()[i];
    if (!(variance > most_m * most_m)) continue;
    const Eigen::Vector3d axis = principal.eigenvectors().col(i);
    const double along = axis.dot(solution.step.segment<3>(3));
    solution.step -= solution.covariance.middleCols<3>(3) * axis * (along / variance);
    solution.decrease -= along * along / variance;
  }
}

}  // namespace

Vector6d RobotNoise::weights() const {
  Vector6d w;
  w << Eigen::Vector3d::Constant(1 / (sigma_rad * sigma_rad)),
      Eigen::Vector3d::Constant(1 / (sigma_m * sigma_m));
  return w;
}

Vector6d robot_error(const HandeyeProblem& problem, const HandeyeState& state, std::size_t view) {
  const HandeyeSight& sight = problem.sights[view];
  return minus(state.base_from_hand[view],
               retract(sight.base_from_hand, state.time_offset_s * sight.velocity));
}

Pose camera_from_board(const HandeyeProblem& problem, const HandeyeState& state, std::size_t view) {
  return with_lengths(camera_from_board(state.places, problem.mount, state.base_from_hand[view]),
                      std::exp(-state.log_board_scale));
}

void HandeyeEquations::add_priors(const HandeyeProblem& problem, const HandeyeState& state) {
  const Shared weights = prior_weights(problem);
  Shared value = Shared::Zero();
  value.segment<3>(3) = state.places.mount_from_camera.translation();
  value.segment<3>(9) = state.places.holder_from_board.translation();
  value[kScale] = state.log_board_scale;
  shared_ = weights.asDiagonal();
  shared_gradient_ = weights.cwiseProduct(value);
  corners_cost_ = value.dot(shared_gradient_);
}

std::optional<HandeyeEquations> HandeyeEquations::at(const HandeyeProblem& problem,
                                                     const HandeyeState& state) {
  HandeyeEquations equations;
  equations.add_priors(problem, state);
  for (std::size_t i = 0; i < problem.sights.size(); ++i) {
    const auto gram =
        products(problem.sights[i], problem.camera, camera_from_board(problem, state, i));
    if (!gram) return std::nullopt;
    equations.add(problem, state, i, *gram);
  }
  return equations;
}

void HandeyeEquations::add(const HandeyeProblem& problem, const HandeyeState& state,
                           std::size_t view, const MatrixXd& gram) {
  const HandeyeSteps steps(state.places, problem.mount, state.base_from_hand[view],
                           std::exp(-state.log_board_scale));
  SixByShared by = SixByShared::Zero();
  by.leftCols<6>() = steps.by_camera;
  by.middleCols<6>(6) = steps.by_board;
  by.col(kScale).tail<3>() = -camera_from_board(problem, state, view).translation();
  const Square6 information = gram.topLeftCorner<6, 6>();
  const Vector6d gradient = gram.topRightCorner<6, 1>();
  const SixByShared weighed = information.lazyProduct(by);
  shared_ += by.transpose().lazyProduct(weighed);
  shared_gradient_ += by.transpose() * gradient;
  corners_cost_ += gram(gram.rows() - 1, gram.cols() - 1);
  OfView of;
  of.information = steps.by_robot.transpose() * information * steps.by_robot;
  of.by_shared = steps.by_robot.transpose() * weighed;
  of.gradient = steps.by_robot.transpose() * gradient;
  of.error = robot_error(problem, state, view);
  of.velocity.setZero();
  if (problem.with_time) of.velocity = problem.sights[view].velocity;
  const MatrixXd lens = gram.block(0, 6, 6, gram.cols() - 7);
  of.by_lens = steps.by_robot.transpose() * lens;
  of.shared_by_lens = by.transpose() * lens;
  views_.push_back(std::move(of));
}

// The information that a robot's pose shares with the other parameters. Its error falls with the
// offset of time.
HandeyeEquations::SixByShared HandeyeEquations::coupling(const OfView& view,
                                                         const Vector6d& weights) const {
  SixByShared coupling = view.by_shared;
  coupling.col(kTime) -= weights.cwiseProduct(view.velocity);
  return coupling;
}

std::optional<HandeyeEquations::Solution> HandeyeEquations::solve(const RobotNoise& noise) const {
  const Vector6d weights = noise.weights();
  SharedSquare schur = shared_;
  Shared gradient = shared_gradient_;
  Solution solution;
  solution.cost = corners_cost_;
  double log_dets = -static_cast<double>(views_.size()) * weights.array().log().sum();
  for (const OfView& view : views_) {
    const Vector6d pull = weights.cwiseProduct(view.error);
    Square6 own = view.information;
    own.diagonal() += weights;
    const Eigen::LLT<Square6> llt(own);
    if (llt.info() != Eigen::Success) return std::nullopt;
    // Half solved: the Schur complement subtracts their squares.
    const SixByShared across = llt.matrixL().solve(coupling(view, weights));
    const Vector6d own_gradient = llt.matrixL().solve(view.gradient + pull);
    schur(kTime, kTime) += view.velocity.dot(weights.cwiseProduct(view.velocity));
    gradient[kTime] -= view.velocity.dot(pull);
    schur.noalias() -= across.transpose().lazyProduct(across);
    gradient.noalias() -= across.transpose().lazyProduct(own_gradient);
    solution.cost += view.error.dot(pull);
    solution.decrease += own_gradient.squaredNorm();
    log_dets += log_det(llt);
  }
  const Eigen::LLT<SharedSquare> llt(schur);
  if (llt.info() != Eigen::Success) return std::nullopt;
  solution.step = -llt.solve(gradient);
  solution.decrease -= solution.step.dot(gradient);
  solution.covariance = llt.solve(SharedSquare::Identity());
  hold_step(held_from_m_, solution);
  solution.objective =
      log_dets + log_det(llt) + solution.cost - solution.decrease + noise_prior(noise);
  if (!std::isfinite(solution.objective)) return std::nullopt;
  return solution;
}

HandeyeState HandeyeEquations::stepped(const HandeyeState& state, const RobotNoise& noise,
                                       const Shared& step) const {
  const Vector6d weights = noise.weights();
  HandeyeState next = state;
  next.places.mount_from_camera = retract(state.places.mount_from_camera, step.head<6>());
  next.places.holder_from_board = retract(state.places.holder_from_board, step.segment<6>(6));
  next.time_offset_s += step[kTime];
  next.log_board_scale += step[kScale];
  for (std::size_t i = 0; i < views_.size(); ++i) {
    const OfView& view = views_[i];
    Square6 own = view.information;
    own.diagonal() += weights;
    const Vector6d right =
        view.gradient + weights.cwiseProduct(view.error) + coupling(view, weights) * step;
    next.base_from_hand[i] =
        retract(state.base_from_hand[i], -Eigen::LLT<Square6>(own).solve(right));
  }
  return next;
}

MatrixXd HandeyeEquations::response_to_lens(const RobotNoise& noise,
                                            const SharedSquare& covariance) const {
  const Vector6d weights = noise.weights();
  MatrixXd sum = MatrixXd::Zero(kShared, views_.empty() ? 0 : views_.front().by_lens.cols());
  for (const OfView& view : views_) {
    Square6 own = view.information;
    own.diagonal() += weights;
    sum += view.shared_by_lens -
           coupling(view, weights).transpose() * Eigen::LLT<Square6>(own).solve(view.by_lens);
  }
  return -covariance * sum;
}

}  // namespace tagcal::internal
