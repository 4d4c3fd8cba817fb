#pragma once

// One view for the normal equations of a pose, and its residuals by their definition.

#include <Eigen/Core>
#include <vector>

#include "batch_fixture.hpp"
#include "tagcal/estimate/pose/refine_pose.hpp"
#include "worlds.hpp"

namespace tagcal {
using namespace internal;

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// A view with memory of its own, some pixels off.
struct Observed {
  Lens lens = centred_pinhole(900);
  std::vector<Vector3d> points;
  std::vector<Vector2d> pixels;
  std::vector<Matrix2> whitening;
  Pose pose;

  ViewPoints view() const { return {points, pixels, whitening}; }
};

inline Matrix2 random_whitening(Random& random) {
  Matrix2 w;
  w << random.normal(), random.normal(), random.normal(), random.normal();
  return w;
}

inline Observed observe(const Lens& lens, std::size_t n, bool whitened, Random& random) {
  Observed o{lens, {}, {}, {}, some_pose(random)};
  while (o.points.size() < n) {
    Vector3d x = std::visit([&](const auto& l) { return point_inside(l, random); }, lens);
    x.z() += 0.1 * x.norm();  // so that differences stay inside
    o.points.push_back(o.pose.inverse() * x);
    o.pixels.push_back(project(lens, x).value() + 3 * Vector2d(random.normal(), random.normal()));
    if (whitened) o.whitening.push_back(random_whitening(random));
  }
  return o;
}

inline Lens with_focal(const Lens& pinhole_lens, double focal_px) {
  const auto p = parameters(pinhole_lens);
  return pinhole(focal_px, focal_px, p[2], p[3]);
}

// Whitened residuals by the definition, one point after the other.
inline VectorXd residuals(const Observed& o, const Pose& pose, double focal_px) {
  const Lens lens = focal_px > 0 ? with_focal(o.lens, focal_px) : o.lens;
  VectorXd r(2 * o.points.size());
  for (std::size_t i = 0; i < o.points.size(); ++i) {
    Vector2d residual = project(lens, pose * o.points[i]).value() - o.pixels[i];
    if (!o.whitening.empty()) residual = o.whitening[i] * residual;
    r.segment<2>(2 * static_cast<Eigen::Index>(i)) = residual;
  }
  return r;
}

// Their Jacobian by (omega, tau, log f), by central differences.
inline MatrixXd differences(const Observed& o, const Pose& pose, double focal_px) {
  const Eigen::Index columns = focal_px > 0 ? 7 : 6;
  MatrixXd j(2 * o.points.size(), columns);
  for (Eigen::Index k = 0; k < columns; ++k) {
    constexpr double kStep = 1e-6;
    Vector6d step = Vector6d::Zero();
    double factor = 1;
    if (k < 6)
      step[k] = kStep;
    else
      factor = std::exp(kStep);
    j.col(k) = (residuals(o, retract(pose, step), focal_px * factor) -
                residuals(o, retract(pose, -step), focal_px / factor)) /
               (2 * kStep);
  }
  return j;
}

}  // namespace tagcal
