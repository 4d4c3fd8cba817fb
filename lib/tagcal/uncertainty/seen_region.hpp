#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tagcal/camera/camera.hpp"

namespace tagcal {

// Nodes over an image, from border to border. With odd numbers of columns and rows one node is the
// centre.
struct ImageGrid {
  ImageSize size;
  int columns = 21;
  int rows = 13;

  Eigen::Vector2d pixel(int column, int row) const;
  std::vector<Eigen::Vector2d> pixels() const;  // row by row from the top
};

// The convex hull of the corners in an image. A lens is extrapolated outside of it.
class SeenRegion {
 public:
  SeenRegion() = default;  // empty
  SeenRegion(const ImageSize& size, std::span<const Eigen::Vector2d> pixels);

  const ImageSize& size() const { return size_; }  // of the image; 0 x 0 for `SeenRegion()`

  // The corners of the hull (pixels), in the direction from x to y.
  const std::vector<Eigen::Vector2d>& hull() const { return hull_; }
  bool contains(const Eigen::Vector2d& pixel) const;
  double share() const;  // of the image's area

  // At least 12 pixels, evenly over the region: the grid nodes in the hull, or points between its
  // centre and its corners if it is too small for the grid. Empty for an empty region.
  std::vector<Eigen::Vector2d> samples() const;

  // Names of the thirds and corners of the image outside the region ("left third", "upper right
  // corner"). Empty if there are none, and for an empty region.
  std::vector<std::string> missing_parts() const;

  // The same as a sentence for users. No value if no part is missing.
  std::optional<std::string> gaps() const;

 private:
  ImageSize size_;
  std::vector<Eigen::Vector2d> hull_;
};

}  // namespace tagcal
