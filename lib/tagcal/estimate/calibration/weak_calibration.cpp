#include "tagcal/estimate/calibration/weak_calibration.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"
#include "tagcal/internal/stopwatch.hpp"
#include "tagcal/solvers/numeric/minimise.hpp"
#include "tagcal/solvers/weak_perspective.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

struct Normal {
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Vector6d gradient = Vector6d::Zero();
  double cost = 0;

  std::optional<DampedStep<Vector6d>> step(double damping) const {
    Eigen::Matrix<double, 6, 6> damped = information;
    // The tilt of a frontal board has no gradient.
    const double floor = 1e-9 * information.trace();  // numeric: keeps the matrix regular
    damped.diagonal() += damping * (information.diagonal().array() + floor).matrix();
    const Vector6d step = -damped.ldlt().solve(gradient);
    if (!step.allFinite()) return std::nullopt;
    return DampedStep<Vector6d>{step, -step.dot(gradient)};
  }
};

// A view by rotation, the image of its points' centroid, and the logarithm of its scale: about the
// centroid scale and position are uncorrelated.
struct CentredView {
  struct State {
    Eigen::Quaterniond rotation;
    Vector2d middle_px;
    double log_scale = 0;
  };
  const ViewProblem& view;
  Vector3d centroid = Vector3d::Zero();

  explicit CentredView(const ViewProblem& v) : view(v) {
    for (const Correspondence& c : v.correspondences)
      centroid += c.point / static_cast<double>(v.correspondences.size());
  }

  std::optional<Normal> at(const State& state) const;

  static State stepped(const State& state, const Vector6d& step) {
    return {exp_rotation(step.head<3>()) * state.rotation, state.middle_px + step.segment<2>(3),
            state.log_scale + step[5]};
  }
};
using State = CentredView::State;

std::optional<Normal> CentredView::at(const State& state) const {
  Normal n;
  const Matrix3d r = state.rotation.toRotationMatrix();
  const double s = std::exp(state.log_scale);
  for (std::size_t i = 0; i < view.correspondences.size(); ++i) {
    const Correspondence& c = view.correspondences[i];
    const Vector3d turned = r * (c.point - centroid);
    Eigen::Matrix<double, 2, 6> j;
    j.leftCols<3>() = -s * cross_matrix(turned).topRows<2>();
    j.middleCols<2>(3).setIdentity();
    j.col(5) = s * turned.head<2>();
    Vector2d residual = s * turned.head<2>() + state.middle_px - c.pixel;
    if (!view.whitening.empty()) {
      const Eigen::Matrix2d w = view.whitening[i];
      j = (w * j).eval();
      residual = (w * residual).eval();
    }
    n.information += j.transpose() * j;
    n.gradient += j.transpose() * residual;
    n.cost += residual.squaredNorm();
  }
  return std::isfinite(n.cost) ? std::optional(n) : std::nullopt;
}

State state_of(const CentredView& centred, const WeakPerspectivePose& pose,
               const Vector2d& centre) {
  const Vector2d middle =
      pose.scale_px_per_m * (pose.camera_from_target * centred.centroid).head<2>() + centre;
  return {pose.camera_from_target.rotation(), middle, std::log(pose.scale_px_per_m)};
}

WeakView weak_view(const CentredView& centred, const State& state, const Normal& n,
                   const Vector2d& centre) {
  WeakView result;
  result.scale_px_per_m = std::exp(state.log_scale);
  const Vector2d t = (state.middle_px - centre) / result.scale_px_per_m -
                     (state.rotation * centred.centroid).head<2>();
  result.camera_from_target = Pose(state.rotation, {t.x(), t.y(), 0});
  result.cost = n.cost;
  // Scales the information to a unit diagonal: its units differ.
  Vector6d unit = n.information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> ldlt(unit.asDiagonal() * n.information *
                                                      unit.asDiagonal());
  // numeric: a smaller pivot of a unit diagonal is rounding
  if (!unit.allFinite() || !(ldlt.vectorD().array() > 1e-12).all()) {
    result.covariance.setConstant(std::numeric_limits<double>::quiet_NaN());
    return result;
  }
  const Eigen::Matrix<double, 6, 6> inverse =
      unit.asDiagonal() * ldlt.solve(Eigen::Matrix<double, 6, 6>::Identity()).eval() *
      unit.asDiagonal();
  // From the centroid's pixel to the translation: t = (m - c) / s - R x.
  Eigen::Matrix<double, 6, 6> by_state = Eigen::Matrix<double, 6, 6>::Identity();
  by_state.block<2, 3>(3, 0) = cross_matrix(state.rotation * centred.centroid).topRows<2>();
  by_state.block<2, 2>(3, 3) /= result.scale_px_per_m;
  by_state.block<2, 1>(3, 5) = -(state.middle_px - centre) / result.scale_px_per_m;
  result.covariance = by_state * inverse * by_state.transpose();
  return result;
}

// The residuals are small against their extent in the image, which those of random pixels are not.
bool is_plausible(const ViewProblem& view, const std::vector<Vector2d>& residuals) {
  Vector2d sum = Vector2d::Zero();
  double square = 0, residual = 0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    sum += view.correspondences[i].pixel;
    square += view.correspondences[i].pixel.squaredNorm();
    residual += residuals[i].squaredNorm();
  }
  const double extent = square - sum.squaredNorm() / static_cast<double>(residuals.size());
  return residual < policy::kWeakResidualShare * extent;
}

Lens lens_of(const WeakView& view, const Vector2d& centre) {
  return Parallel({view.scale_px_per_m, view.scale_px_per_m, centre.x(), centre.y()});
}

std::optional<WeakView> fit_inliers(const ViewProblem& inliers, const Vector2d& centre,
                                    const std::optional<Pose>& perspective_pose) {
  auto fit = perspective_pose ? fit_weak_view(inliers, centre, *perspective_pose) : std::nullopt;
  if (fit && !is_plausible(inliers, residuals_px(inliers.correspondences, lens_of(*fit, centre),
                                                 fit->camera_from_target)))
    return std::nullopt;
  return fit;
}

// No value if no view is used.
std::optional<CalibrationFit> fit_of(const CalibrationInput& input, RobustState state,
                                     std::span<const std::optional<WeakView>> views) {
  CalibrationFit fit;
  fit.bundle = Bundle{&Model::named("weak"), input.image_size, {}, {}, {}};
  fit.whitened = input.whitened;
  fit.summary.converged = true;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!state.selection.uses(v)) continue;
    fit.bundle.views.push_back(chosen(input.views[v].problem, state.selection.inlier[v]));
    fit.bundle.camera_from_target.push_back(views[v]->camera_from_target);
    fit.used.push_back(v);
    fit.summary.cost += views[v]->cost;
    fit.weak.push_back(*views[v]);
  }
  if (fit.weak.empty()) return std::nullopt;
  take_selection(input, std::move(state), fit);
  return fit;
}

}  // namespace

std::optional<WeakView> fit_weak_view(const ViewProblem& view, const Vector2d& centre,
                                      const Pose& perspective_pose) {
  const CentredView centred(view);
  std::vector<Vector3d> points;
  std::vector<Vector2d> pixels;
  for (const Correspondence& c : view.correspondences) {
    points.push_back(c.point);
    pixels.push_back(c.pixel - centre);
  }
  std::vector<WeakView> minima;
  for (const WeakPerspectivePose& pose : weak_perspective_poses(points, pixels)) {
    // The closed form is the minimum already for equal covariances.
    const auto minimum = minimise(centred, state_of(centred, pose, centre));
    if (minimum) minima.push_back(weak_view(centred, minimum->state, minimum->at, centre));
  }
  if (minima.empty()) return std::nullopt;
  if (minima.size() == 1) return minima[0];
  WeakView &a = minima[0], &b = minima[1];
  // numeric: the two minima of a plane have equal costs but for rounding
  if (std::abs(a.cost - b.cost) > 1e-6 * std::max(a.cost, b.cost) + 1e-12)
    return a.cost < b.cost ? a : b;
  const bool first = angle_between_rad(a.camera_from_target, perspective_pose) <=
                     angle_between_rad(b.camera_from_target, perspective_pose);
  WeakView& nearer = first ? a : b;
  nearer.mirrored = (first ? b : a).camera_from_target;
  return nearer;
}

std::optional<CalibrationFit> fit_weak(const CalibrationInput& input,
                                       const CalibrateOptions& options) {
  const Stopwatch stopwatch;
  const auto start = calibration_seed(input.models->named("f"), input.image_size, input.views,
                                      seed_options(options));
  if (!start) return std::nullopt;
  const Vector2d centre = image_centre(input.image_size);
  const std::size_t n = input.views.size();
  std::vector<std::optional<WeakView>> views(n);
  RobustState state{selection_of(*start, options), std::vector<std::vector<double>>(n), 0, 0};
  state.selection.scale_px_per_m.resize(n);
  const auto fit_view = [&](std::size_t v) {
    const ViewProblem& all = input.views[v].problem;
    views[v] =
        fit_inliers(chosen(all, state.selection.inlier[v]), centre, start->camera_from_world[v]);
    state.selection.pose[v].reset();
    state.squares[v].assign(all.correspondences.size(), std::numeric_limits<double>::infinity());
    if (!views[v]) return;
    state.selection.pose[v] = views[v]->camera_from_target;
    state.selection.scale_px_per_m[v] = views[v]->scale_px_per_m;
    state.squares[v] =
        whitened_squares(all, lens_of(*views[v], centre), views[v]->camera_from_target);
  };
  update_until_stable(state, input.whitened, options, [&] {
    for (std::size_t v = 0; v < n; ++v) fit_view(v);
    return true;
  });
  auto fit = fit_of(input, std::move(state), views);
  if (fit) fit->solve_seconds = stopwatch.seconds();
  return fit;
}

}  // namespace tagcal::internal
