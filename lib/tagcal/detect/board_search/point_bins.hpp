#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

// Private to detect.
namespace tagcal::internal {

// Points of a picture in square bins, so that those of a box are found without the others.
class PointBins {
 public:
  // The coordinates must be >= 0.
  explicit PointBins(const std::vector<Eigen::Vector2d>& points) {
    for (const Eigen::Vector2d& point : points) size_ = size_.cwiseMax(bin(point) + ones());
    bins_.resize(static_cast<std::size_t>(size_.prod()));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2i place = bin(points[i]);
      bins_[static_cast<std::size_t>(place.y() * size_.x() + place.x())].push_back(i);
    }
  }

  // Calls visit(i) for each point in the bins that a box touches.
  template <typename Visit>
  void in_box(const Eigen::AlignedBox2d& box, const Visit& visit) const {
    const Eigen::Vector2i low = bin(box.min()).cwiseMax(0);
    const Eigen::Vector2i high = bin(box.max()).cwiseMin(size_ - ones());
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x)
        for (const std::size_t i : bins_[static_cast<std::size_t>(y * size_.x() + x)]) visit(i);
  }

 private:
  static Eigen::Vector2i ones() { return {1, 1}; }
  static Eigen::Vector2i bin(const Eigen::Vector2d& at) {
    constexpr double kSide = 32;  // px
    return (at / kSide).array().floor().cast<int>();
  }

  Eigen::Vector2i size_{0, 0};
  std::vector<std::vector<std::size_t>> bins_;  // row by row
};

}  // namespace tagcal::internal
