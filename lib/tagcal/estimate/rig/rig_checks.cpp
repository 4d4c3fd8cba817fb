#include "tagcal/estimate/rig/rig_checks.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

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
Matrix6 by_place(const RigState& state, std::size_t camera, std::size_t view,
                 const Pose& camera_from_rig) {
  const OwnPose& own = state.own[camera][view];
  Matrix6 step = Matrix6::Identity();
  step.bottomLeftCorner<3, 3>() =
      -cross_matrix(own.camera_from_world.translation() - camera_from_rig.translation());
  return step;
}

// The change of a disagreement by the unit of time.
Vector6d by_time(const RigState& state, const LinkedPoses::Link& link, const Pose& camera_from_rig,
                 const MovingSight& world) {
  // As LinkedSteps::by_instant has it.
  const Matrix6 by_world = step_by(camera_from_rig.rotation_matrix(),
                                   world.sight.rig_from_world.rotation() *
                                       state.poses.world_from_board[link.board].translation());
  return by_world * world.velocity;
}

// 1 for those that are not far from most: within the median by the square of
// policy::kOutlierSigmas.
std::vector<std::uint8_t> consistent(const std::vector<double>& squares) {
  if (squares.empty()) return {};
  const double most = policy::kOutlierSigmas * policy::kOutlierSigmas * median(squares);
  std::vector<std::uint8_t> kept;
  for (const double square : squares) kept.push_back(square <= most);
  return kept;
}

// The normal score of the part of the squares that more parameters explain.
double score(double gain, int num_more, double rest, int freedom) {
  if (freedom < 1 || !(rest > 0) || !(gain > 0)) return 0;
  return variance_ratio_score(gain / num_more / (rest / freedom), num_more, freedom);
}

// The displacement of the corners of views by changes of their disagreements, RMS in px per
// coordinate, is that of a good corner's noise or more. A smaller one is no finding.
bool is_visible(const RigState& state, std::size_t camera, std::span<const Disagreement> views,
                const std::function<Vector6d(std::size_t)>& change) {
  double square = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Disagreement& d = views[i];
    const Eigen::Matrix<double, 6, 6> c = state.own[camera][d.view].covariance;
    const Vector6d step = change(i);
    square += step.dot(c.ldlt().solve(step));
    count += 2 * state.cameras[camera].views[d.view].correspondences.size();
  }
  const double rms = count > 0 ? std::sqrt(square / static_cast<double>(count)) : 0;
  return rms * state.noise_px[camera] > policy::kGoodCornerPx;
}

// The disagreements of a camera's views, and their changes by its place and its clock's offset.
struct TimedViews {
  std::vector<Disagreement> all;
  std::vector<MatrixXd> columns;

  std::vector<double> squares() const {
    std::vector<double> squares;
    for (const Disagreement& d : all) squares.push_back(d.square());
    return squares;
  }
};

// A camera whose clock may be off, and the trajectory of others.
struct ClockProblem {
  const RigState& state;
  std::size_t camera;
  const Trajectory& trajectory;
  const Connected& connected;

  // The views at whose times by an offset the world is known.
  TimedViews at(const Pose& place, double offset) const {
    std::vector<std::optional<MovingSight>> moving;
    for (const double time : state.view_time[camera])
      moving.push_back(world_at(state, time + offset, trajectory));
    const auto world = [&](std::size_t view) {
      return moving[view] ? std::optional(moving[view]->sight) : std::nullopt;
    };
    TimedViews views{disagreements(state, camera, place, world, connected), {}};
    for (const Disagreement& d : views.all) {
      views.columns.emplace_back(6, 7);
      views.columns.back() << by_place(state, camera, d.view, place),
          by_time(state, state.poses.links[camera][d.view], place, *moving[d.view]);
    }
    return views;
  }

  // The score of an offset at its best place: by what it explains of the views that are known with
  // and without it, against the best place without it.
  double score_of(const Pose& place, double offset) const {
    constexpr int kRounds = 3;              // numeric: the place is linear after one
    std::map<std::size_t, double> squares;  // by view
    const TimedViews with = at(place, offset);
    const std::vector<double> all = with.squares();
    const std::vector<std::uint8_t> kept = consistent(all);
    for (std::size_t i = 0; i < all.size(); ++i)
      if (kept[i]) squares[with.all[i].view] = all[i];
    Pose still = place;
    double explained = 0, rest = 0;
    int num_rows = 0;
    for (int round = 0; round < kRounds; ++round) {
      const TimedViews without = at(still, 0);
      LinearFit fit(6);
      rest = 0;
      for (std::size_t i = 0; i < without.all.size(); ++i) {
        const auto found = squares.find(without.all[i].view);
        if (found == squares.end()) continue;
        fit.add(without.all[i], without.columns[i].leftCols<6>());
        rest += found->second;
      }
      num_rows = fit.num_rows;
      if (num_rows == 0) return 0;
      explained = fit.rest() - rest;
      still = retract(still, fit.solution());
    }
    return score(explained, 1, rest, num_rows - 7);
  }
};

}  // namespace

bool tells_offset(const RigState& state) {
  return !state.has_stamps || state.gap <= policy::kOffsetGap;
}

std::optional<ClockFit> fit_clock(const RigState& state, std::size_t camera,
                                  const Trajectory& trajectory, const Connected& connected,
                                  const Pose& camera_from_rig, double offset) {
  constexpr int kRounds = 20;     // a limit of work
  constexpr double kSmall = 0.1;  // numeric: of a standard deviation
  const ClockProblem problem{state, camera, trajectory, connected};
  Pose place = camera_from_rig;
  for (int round = 0; round < kRounds; ++round) {
    const TimedViews views = problem.at(place, offset);
    const std::vector<std::uint8_t> kept = consistent(views.squares());
    LinearFit fit(7);
    for (std::size_t i = 0; i < kept.size(); ++i)
      if (kept[i]) fit.add(views.all[i], views.columns[i]);
    const int freedom = fit.num_rows - 7;
    if (freedom < policy::kFewestDegreesOfFreedom) return std::nullopt;
    const VectorXd x = fit.solution();
    const double variance = MatrixXd(fit.information.ldlt().solve(MatrixXd::Identity(7, 7)))(6, 6);
    const double sigma = std::sqrt(variance * fit.rest() / freedom);
    place = retract(place, x.head<6>());
    offset += x[6];
    if (!(std::abs(x[6]) <= kSmall * sigma)) continue;
    const auto by_offset = [&](std::size_t i) {
      return Vector6d(offset * views.columns[i].rightCols<1>());
    };
    const auto is_rather_a_move = [&] {
      const auto move = camera_move(state, camera, trajectory, connected);
      return move && move->rest < fit.rest() / freedom;
    };
    const bool is_off = problem.score_of(place, offset) > policy::kOutlierSigmas &&
                        is_visible(state, camera, views.all, by_offset) && !is_rather_a_move();
    return ClockFit{{camera, offset, sigma, state.has_stamps}, place, is_off};
  }
  return std::nullopt;
}

std::optional<CameraMove> camera_move(const RigState& state, std::size_t camera,
                                      const Trajectory& trajectory, const Connected& connected) {
  const Pose& place = state.poses.camera_from_rig[camera];
  std::vector<Disagreement> all =
      disagreements(state, camera, place, world_of_instants(state, camera, trajectory), connected);
  std::ranges::sort(all, {}, &Disagreement::instant);
  constexpr std::size_t kFewest = 3;  // numeric: on each side, so that the split has freedom
  if (all.size() < 2 * kFewest) return std::nullopt;
  std::vector<LinearFit> before(1, LinearFit(6));
  for (const Disagreement& d : all) {
    LinearFit sum = before.back();
    sum.add(d, by_place(state, camera, d.view, place));
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
    best = CameraMove{camera, all[i].instant, after.solution() - before[i].solution(),
                      (whole.square - gain) / (whole.num_rows - 12)};
  }
  const auto by_move = [&](std::size_t i) {
    return Vector6d(by_place(state, camera, all[i].view, place) * best->step);
  };
  if (best && !is_visible(state, camera, all, by_move)) best.reset();
  return best;
}

std::optional<PlaceOfPair> place_of(std::span<const Disagreement> disagreements,
                                    const RigState& state, std::size_t camera) {
  const std::vector<Disagreement> all(disagreements.begin(), disagreements.end());
  std::vector<MatrixXd> columns;
  for (const Disagreement& d : all)
    columns.emplace_back(by_place(state, camera, d.view, state.poses.camera_from_rig[camera]));
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
    std::vector<double> squares;
    for (std::size_t i = 0; i < all.size(); ++i) {
      Disagreement moved = all[i];
      moved.step += columns[i] * place->step;
      squares.push_back(moved.square());
    }
    kept = consistent(squares);
  }
  return place;
}

}  // namespace tagcal::internal
