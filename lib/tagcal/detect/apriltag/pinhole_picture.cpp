#include "tagcal/detect/apriltag/pinhole_picture.hpp"

#include <algorithm>
#include <cmath>

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

constexpr int kSide = 256;  // numeric: px; tags that AprilTag does not see otherwise are large
constexpr double kHalfWidth = 2;  // numeric: tangent of half its field of view, 63 degrees

}  // namespace

PinholePicture::PinholePicture(const ImageView8& picture, double focal_sides)
    : size_(picture.size()),
      focal_px_(focal_sides * std::max(size_.width, size_.height)),
      image_({kSide, kSide}) {
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      if (const auto at = in_picture(Vector2d(x, y)))
        image_(x, y) = picture(static_cast<int>(at->x()), static_cast<int>(at->y()));
}

std::optional<Vector2d> PinholePicture::in_picture(const Vector2d& pixel) const {
  const Vector2d tangent = (pixel / (kSide / 2) - Vector2d::Ones()) * kHalfWidth;
  const double r = tangent.norm();
  const Vector2d at = image_centre(size_) + (r > 0 ? focal_px_ * std::atan(r) / r : 0) * tangent;
  if (!(at.minCoeff() >= 0 && at.x() < size_.width && at.y() < size_.height)) return std::nullopt;
  return at;
}

}  // namespace tagcal::internal
