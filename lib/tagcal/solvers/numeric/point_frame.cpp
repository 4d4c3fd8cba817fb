#include "tagcal/solvers/numeric/point_frame.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace tagcal::internal {
namespace {

constexpr double kLine = 1e-6;
constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();

}  // namespace

std::optional<PointFrame> point_frame(std::span<const Eigen::Vector3d> points) {
  if (points.empty()) return std::nullopt;
  const auto n = static_cast<double>(points.size());
  PointFrame frame;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& x : points) sum += x - points[0];
  frame.centre = points[0] + sum / n;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& x : points) {
    const Eigen::Vector3d d = x - frame.centre;
    scatter.noalias() += d * d.transpose();
  }
  const double trace = scatter.trace();
  frame.size = std::sqrt(trace / n);
  if (!(frame.size > 0) || !std::isfinite(frame.size)) return std::nullopt;

  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(scatter / trace);
  frame.axes = eigen.eigenvectors().rowwise().reverse().transpose();
  if (frame.axes.determinant() < 0) frame.axes.row(2) *= -1;
  // The eigenvalues are not used: for a plane or a line they are differences of large numbers.
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& x : points) squares += frame(x).cwiseAbs2();
  frame.extents = (squares / n).cwiseSqrt();
  const double line = kLine + kRounding * frame.centre.norm() / frame.size;
  if (!(frame.extents.tail<2>().norm() > line)) return std::nullopt;
  return frame;
}

}  // namespace tagcal::internal
