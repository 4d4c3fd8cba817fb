#pragma once

#include <functional>
#include <optional>

#include "tagcal/reproject/types.hpp"

namespace tagcal::internal {

// A map, row by row, from wherever it comes. Both functions may be called from several threads.
struct MapRows {
  ImageSize size;
  // Writes the coordinates of row v, size.width each, to x and y.
  std::function<void(int v, float* x, float* y)> fill;
  // The coordinate behind any place of the target.
  std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector2d& pixel)> at;
};

// Throws Error as source_pixel does, and for a target without pixels. Keeps no reference.
MapRows map_rows(const Reprojection& reprojection);

// Keeps a reference to the map. Throws Error if its two images differ in size, or are empty.
MapRows map_rows(const PixelMap& map);

}  // namespace tagcal::internal
