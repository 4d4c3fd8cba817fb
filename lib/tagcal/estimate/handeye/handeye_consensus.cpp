#include "tagcal/estimate/handeye/handeye_consensus.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "tagcal/estimate/policy/handeye_policy.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

using Eigen::MatrixXd;
using Square6 = Eigen::Matrix<double, 6, 6>;
using Mask = std::vector<std::uint8_t>;

// The robot's noise by the poses that the places predict from the views' own.
RobotNoise noise_of_start(const HandeyeProblem& problem, const HandeyePlaces& places) {
  Vector6d squares = Vector6d::Zero();
  for (const HandeyeSight& s : problem.sights) {
    const Pose hand = base_from_hand(places, problem.mount, s.own[0].camera_from_target);
    squares += minus(hand, s.base_from_hand).cwiseAbs2();
  }
  const auto n = 3 * static_cast<double>(problem.sights.size());
  constexpr double kLeast = 0.1;  // numeric: of the prior's median, a start
  return {std::max(std::sqrt(squares.head<3>().sum() / n), kLeast * policy::kPriorRobotRad),
          std::max(std::sqrt(squares.tail<3>().sum() / n), kLeast * policy::kPriorRobotM)};
}

HandeyeProblem with_sights(const HandeyeProblem& problem, const Mask& takes_part) {
  HandeyeProblem some = problem;
  some.sights.clear();
  for (std::size_t i = 0; i < takes_part.size(); ++i)
    if (takes_part[i]) some.sights.push_back(problem.sights[i]);
  return some;
}

// Degrees of freedom of the robot's noise, of rotations or translations, whichever are fewer: the
// variance of the logarithm of a standard deviation is 1 / (2 k), nearly.
double freedoms_of_noise(const NoiseEstimate& noise) {
  return std::max(1.0, 1 / (2 * noise.log_covariance.diagonal().maxCoeff()));
}

// By how many standard deviations the robot's pose of a view contradicts a bundle without this
// view: the difference of what the view's own pose predicts, with its noise, that of the robot, and
// that of the bundle.
double outlyingness(const HandeyeSight& sight, CameraMount mount, const HandeyeMinimum& others) {
  const HandeyeState& state = others.state;
  const Pose own = with_lengths(sight.own[0].camera_from_target, std::exp(state.log_board_scale));
  const Pose hand = base_from_hand(state.places, mount, own);
  const HandeyeSteps steps(state.places, mount, hand);
  // The step of the robot's pose that keeps the view's: of the own pose, less those of the others.
  const Square6 by_own = steps.by_robot.inverse();
  Square6 to_lengths = Square6::Identity();
  to_lengths.bottomRows<3>() *= std::exp(state.log_board_scale);
  Eigen::Matrix<double, 6, HandeyeEquations::kShared> by_shared;
  by_shared << -by_own * steps.by_camera, -by_own * steps.by_board, -sight.velocity,
      by_own.rightCols<3>() * own.translation();
  const Square6 by_noise = by_own * to_lengths;
  Square6 covariance = by_noise * sight.own[0].covariance * by_noise.transpose() +
                       by_shared * others.covariance * by_shared.transpose();
  covariance.diagonal() += others.noise.noise.weights().cwiseInverse();
  const Vector6d error =
      minus(hand, retract(sight.base_from_hand, state.time_offset_s * sight.velocity));
  const double squares = error.dot(covariance.ldlt().solve(error));
  return variance_ratio_score(squares / 6, 6, freedoms_of_noise(others.noise));
}

class Consensus {
 public:
  Consensus(const HandeyeProblem& problem, const RobustHandeyeStart& start)
      : problem_(problem), start_(start), takes_part_(start.takes_part) {}

  std::optional<HandeyeConsensus> find() {
    auto minimum = solve(takes_part_);
    while (minimum && admit(*minimum)) minimum = solve(takes_part_);
    while (minimum && reject(*minimum)) continue;
    if (!minimum) return std::nullopt;
    return HandeyeConsensus{*std::move(minimum), takes_part_};
  }

 private:
  std::optional<HandeyeMinimum> solve(const Mask& takes_part) const {
    return bundle_of(with_sights(problem_, takes_part), start_.places);
  }

  // Adds the views that contradict a bundle least, at most one for each four that there are: the
  // noise of few is so little known that they would admit what is wrong. False if all others
  // contradict it.
  bool admit(const HandeyeMinimum& minimum) {
    std::vector<std::pair<double, std::size_t>> agreeing;
    for (std::size_t i = 0; i < takes_part_.size(); ++i) {
      if (takes_part_[i]) continue;
      const double score = outlyingness(problem_.sights[i], problem_.mount, minimum);
      if (score <= policy::kSignificant) agreeing.emplace_back(score, i);
    }
    std::ranges::sort(agreeing);
    // At least one: the half of kFewestConsensus views has four.
    const auto most = static_cast<std::size_t>(std::ranges::count(takes_part_, 1)) / 4;
    agreeing.resize(std::min(agreeing.size(), most));
    for (const auto& [score, view] : agreeing) takes_part_[view] = 1;
    return !agreeing.empty();
  }

  // Rejects the view of the largest errors that contradicts the bundle of the others. This bundle
  // becomes the minimum. False if no view contradicts it.
  bool reject(HandeyeMinimum& minimum) {
    if (std::ranges::count(takes_part_, 1) < policy::kFewestConsensus) return false;
    constexpr std::size_t kTried = 3;  // a limit of work: errors by the bundle rank alike, nearly
    const std::vector<std::size_t> worst = by_error(minimum);
    for (std::size_t k = 0; k < kTried; ++k) {
      Mask others = takes_part_;
      others[worst[k]] = 0;
      auto without = solve(others);
      if (!without || !contradicts(worst[k], *without)) continue;
      takes_part_ = std::move(others);
      minimum = *std::move(without);
      return true;
    }
    return false;
  }

  bool contradicts(std::size_t view, const HandeyeMinimum& others) const {
    return outlyingness(problem_.sights[view], problem_.mount, others) > policy::kSignificant;
  }

  // The views that take part, largest error first.
  std::vector<std::size_t> by_error(const HandeyeMinimum& minimum) const {
    const HandeyeProblem kept = with_sights(problem_, takes_part_);
    std::vector<std::pair<double, std::size_t>> errors;
    for (std::size_t i = 0; i < takes_part_.size(); ++i)
      if (takes_part_[i])
        errors.emplace_back(-robot_error(kept, minimum.state, errors.size())
                                 .cwiseAbs2()
                                 .dot(minimum.noise.noise.weights()),
                            i);
    std::ranges::sort(errors);
    std::vector<std::size_t> views;
    for (const auto& [error, view] : errors) views.push_back(view);
    return views;
  }

  const HandeyeProblem& problem_;
  const RobustHandeyeStart& start_;
  Mask takes_part_;
};

}  // namespace

std::optional<HandeyeMinimum> bundle_of(const HandeyeProblem& problem,
                                        const HandeyePlaces& places) {
  HandeyeState state{places, {}, 0, 0};
  for (const HandeyeSight& s : problem.sights) state.base_from_hand.push_back(s.base_from_hand);
  return minimise_bundle(problem, std::move(state), noise_of_start(problem, places));
}

std::optional<HandeyeConsensus> find_consensus(const HandeyeProblem& problem,
                                               const RobustHandeyeStart& start, bool rejects) {
  if (rejects && std::ssize(problem.sights) >= policy::kFewestConsensus)
    return Consensus(problem, start).find();
  auto minimum = bundle_of(problem, start.places);
  if (!minimum) return std::nullopt;
  return HandeyeConsensus{*std::move(minimum), Mask(problem.sights.size(), 1)};
}

}  // namespace tagcal::internal
