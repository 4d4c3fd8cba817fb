#pragma once

#include <Eigen/Core>
#include <vector>

#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal::internal {

struct CircleBlob {
  Eigen::Vector2d
      at;  // centre of gravity, px; perspective, the lens and the thresholds displace it
  double diameter_px = 0;
};

// Dark convex blobs by cv::SimpleBlobDetector; at least `num_blobs` are expected in the picture.
std::vector<CircleBlob> circle_blobs(const ImageView8& image, int num_blobs);

}  // namespace tagcal::internal
