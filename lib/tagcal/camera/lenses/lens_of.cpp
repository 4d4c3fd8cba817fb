#include "tagcal/camera/kernels/lens_kernels.hpp"
#include "tagcal/camera/lens.hpp"
#include "tagcal/camera/lenses/domain_limit.hpp"
#include "tagcal/camera/lenses/lens_parameters.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Throws Error unless the value is finite and in the range of the parameter.
void check(const LensParameter& parameter, double value) {
  if (parameter.holds(value)) return;
  const std::string name = "lens: " + std::string(parameter.name);
  if (!std::isfinite(value)) throw Error(name + " is not finite");
  throw Error(name + " must be " + range_text(parameter) + ", got " + short_number(value));
}

// The kernel of a lens, with all of its terms.
PerspectiveKernel<kRational> kernel_of(const Perspective&) { return {}; }
FisheyeKernel kernel_of(const Fisheye&) { return {}; }
ParallelKernel kernel_of(const Parallel&) { return {}; }
DoubleSphereKernel kernel_of(const DoubleSphere&) { return {}; }
ExtendedUnifiedKernel kernel_of(const ExtendedUnified&) { return {}; }

// Projects one point by the kernel of a lens: a pack of one.
template <typename L>
std::optional<Vector2d> project_point(const L& lens, const Vector3d& x,
                                      PointJacobian* by_point = nullptr,
                                      typename L::ParameterJacobian* by_parameters = nullptr) {
  using Eigen::Map, Eigen::Matrix, Eigen::RowMajor;
  PackJacobian<double> jacobian;
  const PackImage<double> image = kernel_of(lens).project(
      lens.parameters().data(), domain_limit(lens), PackPoint<double>{x.x(), x.y(), x.z()},
      by_point || by_parameters ? &jacobian : nullptr);
  if (!image.valid) return std::nullopt;
  if (by_point) *by_point = Map<const Matrix<double, 2, 3, RowMajor>>(jacobian.by_point[0]);
  if (by_parameters)
    *by_parameters =
        Map<const Matrix<double, 2, 2 * kMaxLensParameters, RowMajor>>(jacobian.by_parameters[0])
            .template leftCols<L::kNumParameters>();
  return Vector2d(image.u, image.v);
}

}  // namespace

template <typename Self, int N>
LensOf<Self, N>::LensOf(const Parameters& parameters) : p_(parameters) {
  for (std::size_t i = 0; i < p_.size(); ++i) check(Self::kParameters[i], p_[i]);
}

template <typename Self, int N>
bool LensOf<Self, N>::in_domain(const Vector3d& x_in_camera) const {
  return project(x_in_camera).has_value();
}

template <typename Self, int N>
std::optional<Vector2d> LensOf<Self, N>::project(const Vector3d& x_in_camera) const {
  return project_point(static_cast<const Self&>(*this), x_in_camera);
}

template <typename Self, int N>
std::optional<Vector2d> LensOf<Self, N>::project(const Vector3d& x_in_camera,
                                                 PointJacobian* by_point,
                                                 ParameterJacobian* by_parameters) const {
  return project_point(static_cast<const Self&>(*this), x_in_camera, by_point, by_parameters);
}

template class LensOf<Perspective, 12>;
template class LensOf<Fisheye, 8>;
template class LensOf<Parallel, 6>;
template class LensOf<DoubleSphere, 6>;
template class LensOf<ExtendedUnified, 6>;

Lens make_lens(const LensKind& kind, std::span<const double> parameters) {
  for (std::size_t i = 0; i < kind.parameters.size(); ++i) check(kind.parameters[i], parameters[i]);
  return *kind.lens(parameters);
}

}  // namespace tagcal
