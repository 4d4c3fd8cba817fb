#pragma once

#include <optional>

#include "tagcal/camera/kernels/lens_kernels.hpp"
#include "tagcal/camera/lens.hpp"

namespace tagcal::internal {
namespace {

// Projects one point by the kernel of a lens: a pack of one.
template <typename LensKernel, typename L>
std::optional<Eigen::Vector2d> project_point(
    const L& lens, double limit, const Eigen::Vector3d& x, PointJacobian* by_point = nullptr,
    typename L::ParameterJacobian* by_parameters = nullptr) {
  using Eigen::Map, Eigen::Matrix, Eigen::RowMajor;
  PackJacobian<double> jacobian;
  const PackImage<double> image =
      LensKernel::project(lens.parameters().data(), limit, PackPoint<double>{x.x(), x.y(), x.z()},
                          by_point || by_parameters ? &jacobian : nullptr);
  if (!image.valid) return std::nullopt;
  if (by_point) *by_point = Map<const Matrix<double, 2, 3, RowMajor>>(jacobian.by_point[0]);
  if (by_parameters)
    *by_parameters =
        Map<const Matrix<double, 2, 2 * kMaxLensParameters, RowMajor>>(jacobian.by_parameters[0])
            .template leftCols<L::kNumParameters>();
  return Eigen::Vector2d(image.u, image.v);
}

}  // namespace
}  // namespace tagcal::internal
