#pragma once

#include <optional>

#include "tagcal/reproject/types.hpp"

// Where the pixels of a new picture come from in the picture of a camera.

namespace tagcal {

// The same target, of which the picture shows the part with its upper left pixel at (x, y).
Target cropped(const Target& target, int x, int y, const ImageSize& size);

// The pixel of the camera that shows what the target has at its pixel; no value if the target or
// the camera has nothing there (outside its lens' domain, behind the camera, the back of the
// plane). The pixel may lie outside the camera's picture. Double precision; the same chain as
// pixel_map. Throws Error for a parallel lens where directions are needed.
std::optional<Eigen::Vector2d> source_pixel(const Reprojection& reprojection,
                                            const Eigen::Vector2d& target_pixel);

// source_pixel for all pixels of the target. Threads, 0: one per core; the map does not depend on
// them.
PixelMap pixel_map(const Reprojection& reprojection, int threads = 1);

}  // namespace tagcal
