#include "tagcal/estimate/weak.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

namespace tagcal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Rotation, the image of the points' centroid, and the logarithm of the scale.
struct State {
  Eigen::Quaterniond rotation;
  Vector2d middle_px;
  double log_scale = 0;
};

struct Normal {
  Eigen::Matrix<double, 6, 6> information;
  Vector6d gradient;
  double cost = 0;
};

// Points relative to their centroid, so that scale and place are independent.
struct CentredView {
  const ViewProblem& view;
  Vector3d centroid = Vector3d::Zero();

  explicit CentredView(const ViewProblem& v) : view(v) {
    for (const Correspondence& c : v.correspondences)
      centroid += c.point / static_cast<double>(v.correspondences.size());
  }
};

Normal normal_equations(const CentredView& centred, const State& state) {
  Normal n{Eigen::Matrix<double, 6, 6>::Zero(), Vector6d::Zero(), 0};
  const Matrix3d r = state.rotation.toRotationMatrix();
  const double s = std::exp(state.log_scale);
  for (std::size_t i = 0; i < centred.view.correspondences.size(); ++i) {
    const Correspondence& c = centred.view.correspondences[i];
    const Vector3d turned = r * (c.point - centred.centroid);
    Eigen::Matrix<double, 2, 6> j;
    j.leftCols<3>() = -s * cross_matrix(turned).topRows<2>();
    j.middleCols<2>(3).setIdentity();
    j.col(5) = s * turned.head<2>();
    Vector2d residual = s * turned.head<2>() + state.middle_px - c.pixel;
    if (!centred.view.whitening.empty()) {
      const Eigen::Matrix2d w = centred.view.whitening[i];
      j = (w * j).eval();
      residual = (w * residual).eval();
    }
    n.information += j.transpose() * j;
    n.gradient += j.transpose() * residual;
    n.cost += residual.squaredNorm();
  }
  return n;
}

State start_of(const CentredView& centred, const Pose& near) {
  const Matrix3d r = near.rotation_matrix();
  Vector2d middle = Vector2d::Zero();
  const double count = static_cast<double>(centred.view.correspondences.size());
  for (const Correspondence& c : centred.view.correspondences) middle += c.pixel / count;
  double along = 0, square = 0;
  for (const Correspondence& c : centred.view.correspondences) {
    const Vector2d turned = (r * (c.point - centred.centroid)).head<2>();
    along += turned.dot(c.pixel - middle);
    square += turned.squaredNorm();
  }
  return {near.rotation(), middle, std::log(std::max(along / square, 1e-300))};
}

State stepped(const State& state, const Vector6d& step) {
  return {exp_rotation(step.head<3>()) * state.rotation, state.middle_px + step.segment<2>(3),
          state.log_scale + step[5]};
}

WeakView answer(const CentredView& centred, const State& state, const Vector2d& centre) {
  WeakView result;
  result.scale_px_per_m = std::exp(state.log_scale);
  const Vector2d t = (state.middle_px - centre) / result.scale_px_per_m -
                     (state.rotation * centred.centroid).head<2>();
  result.camera_from_target = Pose(state.rotation, {t.x(), t.y(), 0});
  const Normal n = normal_equations(centred, state);
  result.cost = n.cost;
  // In scaled units: pixels for the tilt, too.
  Vector6d unit = n.information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> ldlt(unit.asDiagonal() * n.information *
                                                      unit.asDiagonal());
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

}  // namespace

std::optional<WeakView> fit_weak_view(const ViewProblem& view, const Vector2d& centre,
                                      const Pose& near) {
  if (view.correspondences.size() < 4) return std::nullopt;
  const CentredView centred(view);
  State state = start_of(centred, near);
  Normal n = normal_equations(centred, state);
  double damping = 1e-4;
  for (int i = 0; i < 200 && damping < 1e12; ++i) {
    Eigen::Matrix<double, 6, 6> damped = n.information;
    const double floor = 1e-9 * n.information.trace();  // a frontal board: no slope by tilt
    damped.diagonal() += damping * (n.information.diagonal().array() + floor).matrix();
    const Vector6d step = -damped.ldlt().solve(n.gradient);
    const State next = stepped(state, step);
    const Normal at_next = normal_equations(centred, next);
    if (!std::isfinite(at_next.cost) || at_next.cost > n.cost) {
      damping *= 10;
      continue;
    }
    const bool done = n.cost - at_next.cost <= 1e-12 * n.cost;
    state = next;
    n = at_next;
    damping = std::max(damping / 10, 1e-12);
    if (done) break;
  }
  if (!std::isfinite(n.cost)) return std::nullopt;
  return answer(centred, state, centre);
}

}  // namespace tagcal
