#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/types.hpp"

namespace tagcal {

// Two lenses compared at one distance, in pixels of the second.
struct LensDifference {
  double distance_m = kInfinitelyFar;
  Pose b_from_a;  // the implied motion of the camera, taken out; at infinity a rotation
  ImageGrid grid;
  MatrixX u_px, v_px;  // b - a at the nodes (rows x columns); NaN where either has no value
  double rms_px = 0;   // over the samples of the region, sqrt(mean |d|^2)
  double max_px = 0;
};

// Where the second lens puts the points that the first one sees, at a distance along its rays, less
// what the pose b_from_a that fits best over the samples (pixels of the first) explains. No value
// where fewer than six samples have a value in both, or no pose is found. Throws Error for images
// of different size.
std::optional<LensDifference> lens_difference(const Camera& a, const Camera& b,
                                              std::span<const Eigen::Vector2d> samples,
                                              double distance_m);

}  // namespace tagcal
