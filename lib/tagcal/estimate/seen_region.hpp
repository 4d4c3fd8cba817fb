#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tagcal/camera/camera.hpp"

namespace tagcal {

// Nodes over an image, from border to border; with odd numbers one of them is its centre.
struct ImageGrid {
  ImageSize size;
  int columns = 21;
  int rows = 13;

  Eigen::Vector2d pixel(int column, int row) const;
  std::vector<Eigen::Vector2d> pixels() const;  // row by row from the top
};

// The part of an image in which corners were seen: their convex hull. Outside of it a lens is
// extrapolated.
class SeenRegion {
 public:
  SeenRegion() = default;  // empty
  SeenRegion(const ImageSize& size, std::span<const Eigen::Vector2d> pixels);

  const std::vector<Eigen::Vector2d>& hull() const { return hull_; }  // positive orientation
  bool contains(const Eigen::Vector2d& pixel) const;
  double share() const;  // of the image's area

  // At least 12 pixels that stand for the region evenly: grid nodes in the hull, the hull's corners
  // where these are too few. Empty for an empty region.
  std::vector<Eigen::Vector2d> samples() const;

  // The thirds and corners of the image that were not seen, by their names ("left third", "upper
  // right corner"); empty where the corners reach all parts, and for an empty region.
  std::vector<std::string> missing_parts() const;

  // The same in one plain sentence; no value where the corners reach all parts of the image.
  std::optional<std::string> gaps() const;

 private:
  ImageSize size_;
  std::vector<Eigen::Vector2d> hull_;
};

}  // namespace tagcal
