#include "tagcal/detect/apriltag/pinhole_picture.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

constexpr int kSide = 256;  // numeric: px; tags that AprilTag does not see otherwise are large
constexpr double kHalfWidth = 2;  // numeric: tangent of half its field of view, 63 degrees

}  // namespace

PinholePicture::PinholePicture(const ImageView8& picture, const Lens& lens)
    : size_(picture.size()), lens_(lens), image_({kSide, kSide}) {
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      if (const auto at = in_picture(Vector2d(x, y)))
        image_(x, y) = picture(static_cast<int>(at->x()), static_cast<int>(at->y()));
}

std::optional<Vector2d> PinholePicture::in_picture(const Vector2d& pixel) const {
  const Vector2d tangent = (pixel / (kSide / 2) - Vector2d::Ones()) * kHalfWidth;
  const auto at = project(lens_, tangent.homogeneous());
  const bool is_inside =
      at && at->minCoeff() >= 0 && at->x() < size_.width && at->y() < size_.height;
  return is_inside ? at : std::nullopt;
}

}  // namespace tagcal::internal
