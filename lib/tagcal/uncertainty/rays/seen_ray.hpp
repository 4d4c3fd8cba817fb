#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "tagcal/camera/kernels/projection_rows.hpp"

namespace tagcal::internal {

// Two unit vectors across a unit vector.
Eigen::Matrix<double, 3, 2> across(const Eigen::Vector3d& direction);

// The ray of a pixel in the camera frame, and how it and the pixel move together, to first order.
struct SeenRay {
  Eigen::Vector3d direction;                  // of length 1
  Eigen::Matrix<double, 3, 2> by_pixel;       // of the direction
  Eigen::Matrix<double, 2, 6> pixel_by_pose;  // (omega, tau) of a point at a distance of 1 m
  RowMajorX pixel_by_parameters;              // those of `free`
};

// No value where the pixel has no ray. Throws Error for a parallel lens.
std::optional<SeenRay> seen_ray(const Lens& lens, const Eigen::Vector2d& pixel,
                                std::span<const FreeParameter> free = {});

}  // namespace tagcal::internal
