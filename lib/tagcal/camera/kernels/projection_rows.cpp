#include "tagcal/camera/kernels/projection_rows.hpp"

#include "tagcal/camera/batch.hpp"

namespace tagcal::internal {

std::optional<ProjectionRows> projection_rows(const Lens& lens, const Pose& camera_from_source,
                                              std::span<const Eigen::Vector3d> x_in_source,
                                              std::span<const FreeParameter> free) {
  const std::size_t n = x_in_source.size();
  const auto rows = static_cast<Eigen::Index>(2 * n);
  ProjectionRows r{std::vector<Eigen::Vector2d>(n), RowMajor6(rows, 6),
                   RowMajorX(rows, static_cast<Eigen::Index>(free.size()))};
  std::vector<std::uint8_t> valid(n);
  const auto span_of = [](auto& matrix) {
    return std::span(matrix.data(), static_cast<std::size_t>(matrix.size()));
  };
  if (project_with_jacobians(lens, camera_from_source, x_in_source, free,
                             {r.pixels, valid, span_of(r.by_pose), span_of(r.by_parameters)}) < n)
    return std::nullopt;
  return r;
}

}  // namespace tagcal::internal
