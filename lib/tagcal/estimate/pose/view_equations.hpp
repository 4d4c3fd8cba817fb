#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/camera/kernels/project_dispatch.hpp"
#include "tagcal/camera/lens.hpp"
#include "tagcal/solvers/solutions.hpp"

namespace tagcal::internal {

// One view for the kernels; the arrays belong to the caller. Whitening matrices W have W'W = C^-1
// for the covariance C of a pixel: one for each pixel, or none.
struct ViewPoints {
  std::span<const Eigen::Vector3d> points;  // target frame
  std::span<const Eigen::Vector2d> pixels;
  std::span<const Matrix2> whitening = {};

  std::size_t size() const { return points.size(); }
};

// The unknowns of one view: rotation, translation, and focal length.
struct ViewState {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  double focal_px = 0;  // for pose with focal length only
};
ViewState state_of(const Pose& camera_from_target, double focal_px = 0);
Pose pose_of(const ViewState& state);

// The rotation of the quaternion (1, omega / 2): equal to the exponential to second order.
[[gnu::always_inline]] inline Eigen::Matrix3d small_rotation(const Eigen::Vector3d& omega) {
  const double x = omega.x() / 2, y = omega.y() / 2, z = omega.z() / 2;
  const double s = 2 / (1 + x * x + y * y + z * z);
  Eigen::Matrix3d r;
  r << 1 - s * (y * y + z * z), s * (x * y - z), s * (x * z + y),  //
      s * (x * y + z), 1 - s * (x * x + z * z), s * (y * z - x),   //
      s * (x * z - y), s * (y * z + x), 1 - s * (x * x + y * y);
  return r;
}

// The state after a step (omega, tau) and, for N = 7, of log f.
template <int N>
ViewState moved(const ViewState& state, const Eigen::Matrix<double, N, 1>& step) {
  ViewState next;
  next.rotation.noalias() = small_rotation(step.template head<3>()) * state.rotation;
  next.translation = state.translation + step.template segment<3>(3);
  if constexpr (N == 7) next.focal_px = state.focal_px * std::exp(step[6]);
  return next;
}

// J'J (its upper triangle), J'r and r'r of the whitened residuals r = projected - observed, with J
// by (omega, tau) of `retract` and, for N = 7, by log f.
template <int N>
struct NormalEquations {
  Eigen::Matrix<double, N, N> information;
  Eigen::Matrix<double, N, 1> gradient;
  double cost = 0;
};

// The squared whitened residuals of a view, by the kernels for this processor.
class ViewResiduals {
 public:
  // Both must outlive it.
  ViewResiduals(const Lens& lens, const ViewPoints& view);

  // One for each point, infinite outside the lens' domain. If the state has a focal length, the
  // lens must be a pinhole, and the state's focal length replaces its own.
  std::span<const double> at(const ViewState& state);

  // Projected pixels of the last call.
  std::span<const Eigen::Vector2d> projected() const { return projected_; }

 private:
  ViewPoints view_;
  ProjectJob job_;
  ProjectKernelKind kind_;
  std::vector<Eigen::Vector2d> projected_;
  std::vector<std::uint8_t> valid_;
  std::vector<double> squares_;
};

// Sums the normal equations of a view, by the kernels for this processor.
class ViewSums {
 public:
  ViewSums(const Lens& lens, const ViewPoints& view);

  // False if a point is outside the lens' domain. For N = 7 the lens must be a pinhole, and the
  // state's focal length replaces its own.
  bool at(const ViewState& state, NormalEquations<6>& equations);
  bool at(const ViewState& state, NormalEquations<7>& equations);

  std::size_t num_points() const { return job_.num_points; }

 private:
  SumJob job_;
  ProjectKernelKind kind_;
};

// Shapes of a target: the displacement of each point by a unit of each of four shapes, the first
// three along `normal`, the last one along `across` (target frame). No shapes if `of_points` is
// empty.
struct ViewShapes {
  std::span<const Eigen::Vector4d> of_points;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Vector3d across = Eigen::Vector3d::Zero();
};

// Row terms of a view, in proportion to y - middle_row for a pixel of row y. Without `velocities`
// they are (a, b), by which the pixel is displaced: what acts like a rolling shutter. With it they
// are the coefficients of six velocities a row, its columns (omega, tau) of `retract`, of a camera
// that moves while a rolling shutter reads its rows; the points are displaced by the start of that
// motion already. They have a normal prior about zero, of standard deviation `sigma` in units of
// the (whitened) residuals.
struct ViewRowTerms {
  double middle_row = 0;
  double sigma = 0;  // 0: none
  std::optional<Matrix6> velocities = {};
  Vector6d start = Vector6d::Zero();

  int count() const { return sigma > 0 ? velocities ? 6 : 2 : 0; }
};

// Sums the normal equations of a view by its pose, the free parameters of a model, the shapes of
// the target and the row terms.
class ParameterSums {
 public:
  // All must outlive it.
  ParameterSums(const ViewPoints& view, std::span<const FreeParameter> free,
                const ViewShapes& shapes = {}, const ViewRowTerms& row_terms = {});

  // [J | r]'[J | r] (its upper triangle) of the whitened residuals r, with J by (omega, tau) of
  // `retract`, by the free parameters and by the shapes. The row terms are linear, and are
  // eliminated: the products are those of the residuals with the best row terms. False if a point
  // is outside the lens' domain.
  bool at(const Lens& lens, const Pose& camera_from_target, Eigen::MatrixXd& gram);

  // The row terms that are best at the last state, (a, b, 0 ..) or six coefficients; zero without
  // any.
  Vector6d row_terms() const;

  // Information of the row terms and their gradient (of half the cost) for none, at
  // the last state, with a free pose and all else held; without their prior.
  struct RowEquations {
    Eigen::MatrixXd information;
    Eigen::VectorXd gradient;
  };
  RowEquations row_equations() const;

  // The products at the last state with one column, that of these six coefficients, in place of the
  // row terms, and with the residuals for none; the prior of the row terms must be weak.
  Eigen::MatrixXd with_velocity(const Vector6d& terms) const;

 private:
  Eigen::MatrixXd row_information() const;  // with their prior

  std::span<const FreeParameter> free_;
  ViewShapes shapes_;
  ViewRowTerms row_terms_;
  SumJob job_;
  Eigen::MatrixXd all_;  // the last products, with the row terms before the residual
};

// Computes rows R with R'R = the gram matrix of rows [J | r] (its upper triangle): the same cost,
// gradient and J'J in as many rows as columns. The rows after the first `first` ones are free of
// the first `first` columns. Cholesky's decomposition, which takes the other columns in the order
// of what the earlier ones leave of them (Higham, Accuracy and Stability of Numerical Algorithms,
// 2002, 10.3): in a fixed order the numerators and denominators of a rational lens, which one view
// hardly separates, lose a quarter of a gradient to rounding. A column that depends on earlier ones
// gives no row; r is the last column.
void compressed_rows(const Eigen::MatrixXd& gram, Eigen::Index first, Eigen::MatrixXd& r);

}  // namespace tagcal::internal
