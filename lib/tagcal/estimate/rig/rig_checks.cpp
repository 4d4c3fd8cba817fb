#include "tagcal/estimate/rig/rig_checks.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Least squares of disagreements by parameters: minimises the sum of |e + A x|^2 in units of the
// covariances.
struct LinearFit {
  MatrixXd information;
  VectorXd gradient;
  double square = 0;  // of e
  int num_rows = 0;

  explicit LinearFit(Eigen::Index n)
      : information(MatrixXd::Zero(n, n)), gradient(VectorXd::Zero(n)) {}

  void add(const Disagreement& d, const MatrixXd& by_parameters) {
    const Eigen::Matrix<double, 6, 6> c = d.covariance;
    const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> ldlt(c);
    const MatrixXd weighted = ldlt.solve(by_parameters);
    information += by_parameters.transpose() * weighted;
    gradient += weighted.transpose() * d.step;
    square += d.step.dot(ldlt.solve(d.step));
    num_rows += 6;
  }

  VectorXd solution() const { return -Eigen::LDLT<MatrixXd>(information).solve(gradient); }
  double gain() const { return -gradient.dot(solution()); }
  double rest() const { return std::max(0.0, square - gain()); }
};

// The change of a disagreement by a step of the camera's place.
Matrix6 by_place(const RigState& state, std::size_t camera, std::size_t view) {
  const OwnPose& own = state.own[camera][view];
  Matrix6 step = Matrix6::Identity();
  step.bottomLeftCorner<3, 3>() = -cross_matrix(own.camera_from_world.translation() -
                                                state.poses.camera_from_rig[camera].translation());
  return step;
}

// The change of a disagreement by the unit of time.
std::optional<Vector6d> by_time(const RigState& state, std::size_t camera, const Disagreement& d,
                                const Trajectory& trajectory) {
  const std::optional<WorldMotion> motion = motion_at(state, d.instant, trajectory);
  if (!motion) return std::nullopt;
  // As LinkedSteps::by_instant has it at the trajectory.
  const LinkedPoses::Link& link = state.poses.links[camera][d.view];
  const Pose& world = trajectory[d.instant]->rig_from_world;
  const Matrix6 by_world = step_by(
      (state.poses.camera_from_rig[camera].rotation() * link.motion.rotation()).toRotationMatrix(),
      world.rotation() * state.poses.world_from_board[link.board].translation());
  return Vector6d(by_world * motion->velocity);
}

// 1 for those that are not far from most: their squares are within the median by the square of
// policy::kOutlierSigmas.
std::vector<std::uint8_t> consistent(const std::vector<Disagreement>& all, const VectorXd& x,
                                     const std::vector<MatrixXd>& by_parameters) {
  std::vector<double> squares;
  for (std::size_t i = 0; i < all.size(); ++i) {
    Disagreement moved = all[i];
    moved.step += by_parameters[i] * x;
    squares.push_back(moved.square());
  }
  const double most = policy::kOutlierSigmas * policy::kOutlierSigmas * median(squares);
  std::vector<std::uint8_t> kept;
  for (const double square : squares) kept.push_back(square <= most);
  return kept;
}

// The normal score of the part of the squares that more parameters explain.
double score(double gain, int num_more, double rest, int freedom) {
  if (freedom < 1 || !(rest > 0)) return 0;
  return variance_ratio_score(gain / num_more / (rest / freedom), num_more, freedom);
}

// The displacement of the corners of views by changes of their disagreements, RMS in px per
// coordinate, is that of a good corner's noise or more. A smaller one is no finding.
bool is_visible(const RigState& state, std::size_t camera, std::span<const Disagreement> views,
                const std::function<Vector6d(const Disagreement&)>& change) {
  double square = 0;
  std::size_t count = 0;
  for (const Disagreement& d : views) {
    const Eigen::Matrix<double, 6, 6> c = state.own[camera][d.view].covariance;
    const Vector6d step = change(d);
    square += step.dot(c.ldlt().solve(step));
    count += 2 * state.cameras[camera].views[d.view].correspondences.size();
  }
  const double rms = count > 0 ? std::sqrt(square / static_cast<double>(count)) : 0;
  return rms * state.noise_px[camera] > policy::kGoodCornerPx;
}

}  // namespace

std::optional<WorldMotion> motion_at(const RigState& state, std::size_t instant,
                                     const Trajectory& trajectory) {
  if (instant == 0 || instant + 1 >= trajectory.size()) return std::nullopt;
  const std::optional<Sight>& before = trajectory[instant - 1];
  const std::optional<Sight>& at = trajectory[instant];
  const std::optional<Sight>& after = trajectory[instant + 1];
  if (!before || !at || !after) return std::nullopt;
  const double back = state.time[instant] - state.time[instant - 1];
  const double ahead = state.time[instant + 1] - state.time[instant];
  if (!(back > 0 && ahead > 0)) return std::nullopt;
  if (state.has_stamps && std::max(back, ahead) > policy::kLongestGap) return std::nullopt;
  const Vector6d last = minus(before->rig_from_world, at->rig_from_world) / back;
  const Vector6d next = minus(after->rig_from_world, at->rig_from_world) / ahead;
  return WorldMotion{(next * back - last * ahead) / (back + ahead),
                     2 * (next + last) / (back + ahead)};
}

bool tells_offset(const RigState& state) {
  if (!state.has_stamps || state.time.size() < 2) return true;
  std::vector<double> gaps;
  for (std::size_t t = 1; t < state.time.size(); ++t)
    gaps.push_back(state.time[t] - state.time[t - 1]);
  return median(std::move(gaps)) <= policy::kOffsetGap;
}

std::optional<ClockFit> fit_clock(const RigState& state, std::size_t camera,
                                  const Trajectory& trajectory, const Connected& connected) {
  std::vector<Disagreement> all =
      disagreements(state, camera, state.poses.camera_from_rig[camera], trajectory, connected);
  std::erase_if(all, [&](const Disagreement& d) { return !by_time(state, camera, d, trajectory); });
  std::vector<MatrixXd> columns;
  for (const Disagreement& d : all) {
    columns.emplace_back(6, 7);
    columns.back() << by_place(state, camera, d.view), *by_time(state, camera, d, trajectory);
  }
  constexpr int kRounds = 3;  // numeric: the members are stable after two
  std::vector<std::uint8_t> kept(all.size(), 1);
  std::optional<ClockFit> result;
  for (int round = 0; round < kRounds; ++round) {
    LinearFit with(7), without(6);
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (!kept[i]) continue;
      with.add(all[i], columns[i]);
      without.add(all[i], columns[i].leftCols<6>());
    }
    const int freedom = with.num_rows - 7;
    if (freedom < policy::kFewestDegreesOfFreedom) return std::nullopt;
    const VectorXd x = with.solution();
    const double rest = with.rest();
    const double variance = MatrixXd(with.information.ldlt().solve(MatrixXd::Identity(7, 7)))(6, 6);
    result =
        ClockFit{{camera, x[6], std::sqrt(variance * rest / freedom), state.has_stamps}, false};
    result->is_off = score(with.gain() - without.gain(), 1, rest, freedom) > policy::kOutlierSigmas;
    kept = consistent(all, x, columns);
  }
  const auto by_offset = [&](const Disagreement& d) {
    return Vector6d(result->clock.offset * *by_time(state, camera, d, trajectory));
  };
  result->is_off = result->is_off && is_visible(state, camera, all, by_offset);
  return result;
}

std::optional<CameraMove> camera_move(const RigState& state, std::size_t camera,
                                      const Trajectory& trajectory, const Connected& connected) {
  std::vector<Disagreement> all =
      disagreements(state, camera, state.poses.camera_from_rig[camera], trajectory, connected);
  std::ranges::sort(all, {}, &Disagreement::instant);
  constexpr std::size_t kFewest = 3;  // numeric: on each side, so that the split has freedom
  if (all.size() < 2 * kFewest) return std::nullopt;
  std::vector<LinearFit> before(1, LinearFit(6));
  for (const Disagreement& d : all) {
    LinearFit sum = before.back();
    sum.add(d, by_place(state, camera, d.view));
    before.push_back(sum);
  }
  const LinearFit& whole = before.back();
  std::optional<CameraMove> best;
  double most = policy::kOutlierSigmas;
  for (std::size_t i = kFewest; i + kFewest <= all.size(); ++i) {
    LinearFit after = whole;
    after.information -= before[i].information;
    after.gradient -= before[i].gradient;
    const double gain = before[i].gain() + after.gain();
    const double s = score(gain - whole.gain(), 6, whole.square - gain, whole.num_rows - 12);
    if (s <= most) continue;
    most = s;
    best = CameraMove{camera, all[i].instant, after.solution() - before[i].solution()};
  }
  const auto by_move = [&](const Disagreement& d) {
    return Vector6d(by_place(state, camera, d.view) * best->step);
  };
  if (best && !is_visible(state, camera, all, by_move)) best.reset();
  return best;
}

std::optional<PlaceOfPair> place_of(std::span<const Disagreement> disagreements,
                                    const RigState& state, std::size_t camera) {
  const std::vector<Disagreement> all(disagreements.begin(), disagreements.end());
  std::vector<MatrixXd> columns;
  for (const Disagreement& d : all) columns.emplace_back(by_place(state, camera, d.view));
  constexpr int kRounds = 3;  // numeric: the members are stable after two
  std::vector<std::uint8_t> kept(all.size(), 1);
  std::optional<PlaceOfPair> place;
  for (int round = 0; round < kRounds; ++round) {
    LinearFit fit(6);
    for (std::size_t i = 0; i < all.size(); ++i)
      if (kept[i]) fit.add(all[i], columns[i]);
    if (fit.num_rows < 6 + 6) return std::nullopt;  // numeric: two views leave a residual
    const double variance = std::max(1.0, fit.rest() / (fit.num_rows - 6));
    place = PlaceOfPair{fit.solution(),
                        variance * fit.information.ldlt().solve(MatrixXd::Identity(6, 6))};
    kept = consistent(all, place->step, columns);
  }
  return place;
}

}  // namespace tagcal::internal
