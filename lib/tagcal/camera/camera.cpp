#include "tagcal/camera/camera.hpp"

#include <cassert>
#include <cmath>
#include <numbers>

namespace tagcal {

bool contains(const ImageSize& size, const Eigen::Vector2d& pixel) {
  return pixel.x() >= -0.5 && pixel.x() < size.width - 0.5 && pixel.y() >= -0.5 &&
         pixel.y() < size.height - 0.5;
}

Eigen::Vector2d image_centre(const ImageSize& size) {
  return {(size.width - 1) / 2.0, (size.height - 1) / 2.0};
}

double focal_from_field_of_view_px(double field_of_view_rad, double extent_px) {
  assert(field_of_view_rad > 0 && field_of_view_rad < std::numbers::pi);
  return extent_px / (2 * std::tan(field_of_view_rad / 2));
}

double field_of_view_rad(double focal_px, double extent_px) {
  assert(focal_px > 0);
  return 2 * std::atan2(extent_px, 2 * focal_px);
}

}  // namespace tagcal
