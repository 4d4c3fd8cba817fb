#include "tagcal/camera/kernels/project_dispatch.hpp"

#include <algorithm>
#include <numeric>
#include <string>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/camera/lenses/domain_limit.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/processor.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

bool all_zero(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return v == 0; });
}

// The smallest kind that has all terms that are not zero and all columns that are wanted. `wanted`
// has one bit for each lens parameter.
ProjectKernelKind kernel_kind(const Perspective& lens, unsigned wanted) {
  const std::span<const double> p = lens.parameters();
  if (!all_zero(p.subspan(kK4)) || wanted >> kK4) return kRational;
  return !all_zero(p.subspan(kK1)) || wanted >> kK1 ? kBrownConrady : kPinhole;
}
ProjectKernelKind kernel_kind(const Fisheye&, unsigned) { return kFisheye; }
ProjectKernelKind kernel_kind(const Parallel&, unsigned) { return kParallel; }
ProjectKernelKind kernel_kind(const DoubleSphere&, unsigned) { return kDoubleSphere; }
ProjectKernelKind kernel_kind(const ExtendedUnified&, unsigned) { return kExtendedUnified; }

void check_size(const char* name, std::size_t size, std::size_t expected) {
  if (size != expected)
    throw Error(std::string("project: ") + name + ": must have size " + std::to_string(expected) +
                ", got " + std::to_string(size));
}

void set_pose(const Pose& camera_from_source, ViewJob& job) {
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(job.rotation) =
      camera_from_source.rotation_matrix();
  Eigen::Map<Vector3d>(job.translation) = camera_from_source.translation();
}

}  // namespace

const ProjectKernels& fastest_kernels() {
  static const bool is_avx2 = kAvx2Kernels.pixels[kPinhole] && runs_avx2();
  return is_avx2 ? kAvx2Kernels : kPortableKernels;
}

unsigned set_columns(std::span<const FreeParameter> free, std::size_t num_parameters,
                     unsigned* columns) {
  if (free.size() > num_parameters)
    throw Error("project: " + std::to_string(free.size()) + " free parameters of a lens that has " +
                std::to_string(num_parameters));
  unsigned wanted = 0;
  for (std::size_t i = 0; i < free.size(); ++i) {
    for (const int k : free[i].lens_parameters) {
      if (k < 0 || static_cast<std::size_t>(k) >= num_parameters)
        throw Error("project: " + std::string(free[i].name) + " is no parameter of the lens");
      columns[i] |= 1u << k;
    }
    if (columns[i] == 0)
      throw Error("project: " + std::string(free[i].name) + " sets no parameter of the lens");
    wanted |= columns[i];
  }
  return wanted;
}

ProjectKernelKind set_lens(const Lens& lens, unsigned wanted, ViewJob& job) {
  const std::span<const double> p = parameters(lens);
  std::copy(p.begin(), p.end(), job.parameters);
  job.limit = std::visit([](const auto& l) { return domain_limit(l); }, lens);
  return std::visit([&](const auto& l) { return kernel_kind(l, wanted); }, lens);
}

std::size_t project_by(const ProjectKernels& kernels, const Lens& lens,
                       const Pose& camera_from_source, std::span<const Vector3d> x_in_source,
                       std::span<const FreeParameter> free, const ProjectionOutput& output) {
  const std::size_t n = x_in_source.size();
  check_size("pixels", output.pixels.size(), n);
  check_size("valid", output.valid.size(), n);
  const bool by_pose = !output.by_pose.empty(), by_parameters = !output.by_parameters.empty();
  if (by_pose) check_size("by_pose", output.by_pose.size(), 12 * n);
  if (by_parameters) check_size("by_parameters", output.by_parameters.size(), 2 * free.size() * n);
  if (n == 0) return 0;

  ProjectJob job;
  job.num_points = n;
  job.points = x_in_source.front().data();
  job.pixels = output.pixels.front().data();
  job.valid = output.valid.data();
  if (by_pose) job.by_pose = output.by_pose.data();
  if (by_parameters) job.by_parameters = output.by_parameters.data();
  set_pose(camera_from_source, job);
  const unsigned wanted =
      by_parameters ? set_columns(free, parameters(lens).size(), job.columns) : 0;
  if (by_parameters) job.num_columns = static_cast<int>(free.size());
  const ProjectKernelKind kind = set_lens(lens, wanted, job);
  (by_pose || by_parameters ? kernels.with_jacobians : kernels.pixels)[kind](job);
  return std::accumulate(output.valid.begin(), output.valid.end(), std::size_t{0});
}

}  // namespace tagcal::internal

namespace tagcal {

std::size_t project_with_jacobians(const Lens& lens, const Pose& camera_from_source,
                                   std::span<const Eigen::Vector3d> x_in_source,
                                   std::span<const FreeParameter> free,
                                   const ProjectionOutput& output) {
  return internal::project_by(internal::fastest_kernels(), lens, camera_from_source, x_in_source,
                              free, output);
}

std::size_t project(const Lens& lens, const Pose& camera_from_source,
                    std::span<const Eigen::Vector3d> x_in_source, std::span<Eigen::Vector2d> pixels,
                    std::span<std::uint8_t> valid) {
  return internal::project_by(internal::fastest_kernels(), lens, camera_from_source, x_in_source,
                              {}, {pixels, valid});
}

}  // namespace tagcal
