#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/camera/model.hpp"
#include "tagcal/solvers/numeric/minimise.hpp"

// The lens of a model by which rays meet pixels, in the camera frame.

namespace tagcal::internal {

// Pixels and the directions of their rays.
struct Sightings {
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Vector3d> rays;

  std::size_t size() const { return rays.size(); }
  void add(const Eigen::Vector2d& pixel, const Eigen::Vector3d& ray) {
    pixels.push_back(pixel);
    rays.push_back(ray);
  }
};

// Residuals (two for each sighting) and their Jacobian by the free parameters.
struct RayEquations {
  Eigen::VectorXd residuals;
  Eigen::MatrixXd jacobian;
  double cost = 0;

  std::optional<DampedStep<Eigen::VectorXd>> step(double damping) const;  // of scaled columns
};

// No value if a sighting is outside the domain of the lens.
std::optional<RayEquations> ray_equations(const Lens& lens, std::span<const FreeParameter> free,
                                          const Sightings& seen);

// 1 / norm of each column; 1 for a column of zeros.
Eigen::VectorXd column_scales(const Eigen::MatrixXd& jacobian);

// The free values of a model, and the equations there.
struct LensFromRays {
  std::vector<double> free_values;
  RayEquations at;
};

// Least squares over all sightings (`minimise`): the best of those from `starts` (free
// values), from a linear solution about the pixel `centre` of the optical axis, and from a lens
// without distortion. No value if no start sees all. Precondition: one sighting or more; their rays
// are in front of the camera for a perspective.
std::optional<LensFromRays> lens_from_rays(const Model& model, const ImageSize& size,
                                           const Sightings& seen, const Eigen::Vector2d& centre,
                                           std::vector<std::vector<double>> starts);

}  // namespace tagcal::internal
