#pragma once

#include <Eigen/Core>
#include <vector>

#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal::internal {

// The centres of gravity of dark convex blobs by cv::SimpleBlobDetector, px; at least `num_blobs`
// are expected in the picture. Perspective, the lens and the thresholds displace them.
std::vector<Eigen::Vector2d> circle_blobs(const ImageView8& image, int num_blobs);

}  // namespace tagcal::internal
