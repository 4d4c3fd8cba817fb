#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "tagcal/uncertainty/known_rig.hpp"

namespace tagcal {

// The pixel at which a camera of a rig sees a point, with the covariance of its noise.
struct SeenPixel {
  std::size_t camera = 0;
  UncertainPixel at;
};

enum class TriangulationStatus {
  ok,
  few_cameras,  // fewer than two
  no_ray,       // a pixel is outside the lens' domain
  far,          // the rays are parallel within their errors: the distance has no bound
  behind,       // the rays meet behind a camera
};
std::string_view status_name(TriangulationStatus status);

struct TriangulatedPoint {
  TriangulationStatus status = TriangulationStatus::few_cameras;
  // In the frame of the rig; of status ok. The covariance is by the noise of the pixels, and by
  // the joint covariance of the places and lenses of the cameras.
  UncertainPoint point;
  std::vector<Eigen::Vector2d> residuals_px;  // measured - projected
  double rms_px = 0;                          // sqrt(sum |r|^2 / pixels)
  // The squared residuals over their covariance, of 2 n - 3 degrees of freedom.
  double chi_square = 0;
  // The pixels that contradict the others, by index: one of three or more, both of two; empty if
  // chi_square is what the covariances allow.
  std::vector<std::size_t> contradicting;
};

// The point whose projections agree best with the pixels of two or more cameras: least squares of
// the residuals, weighted by their joint covariance (noise, camera_error_px, places, lenses).
// Throws Error for a camera that the rig does not have or that is given twice, a parallel lens, and
// a covariance that does not fit the rig.
TriangulatedPoint triangulate(const KnownRig& rig, std::span<const SeenPixel> seen);

}  // namespace tagcal
