#include "tagcal/detect/opencv/circle_blobs.hpp"

#include <algorithm>
#include <array>
#include <opencv2/features2d.hpp>

#include "tagcal/detect/opencv/mat_of.hpp"
#include "tagcal/detect/policy/policy.hpp"

namespace tagcal::internal {
namespace {

// The grey level below which a share of the pixels lies.
float level_of_share(const ImageView8& image, double share) {
  std::array<std::size_t, 256> counts{};
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) ++counts[image(x, y)];
  const double wanted = share * image.width() * image.height();
  std::size_t sum = 0, level = 0;
  while (level < 255 && static_cast<double>(sum += counts[level]) < wanted) ++level;
  return static_cast<float>(level);
}

cv::SimpleBlobDetector::Params blob_parameters(const ImageView8& image, int num_blobs) {
  cv::SimpleBlobDetector::Params p;
  p.minThreshold = level_of_share(image, policy::kBlobTailShare);
  p.maxThreshold = level_of_share(image, 1 - policy::kBlobTailShare);
  p.thresholdStep = std::max(1.0f, (p.maxThreshold - p.minThreshold) / policy::kBlobThresholds);
  p.minDistBetweenBlobs = policy::kBlobMinDistancePx;
  p.minArea = policy::kBlobMinAreaPx2;
  p.maxArea = static_cast<float>(image.width()) * static_cast<float>(image.height()) /
              static_cast<float>(num_blobs);
  p.minConvexity = policy::kBlobMinConvexity;
  return p;
}

}  // namespace

std::vector<CircleBlob> circle_blobs(const ImageView8& image, int num_blobs) {
  const cv::SimpleBlobDetector::Params parameters = blob_parameters(image, num_blobs);
  if (parameters.maxThreshold - parameters.minThreshold < policy::kMinContrast) return {};
  std::vector<cv::KeyPoint> blobs;
  cv::SimpleBlobDetector::create(parameters)->detect(mat_of(image), blobs);
  std::vector<CircleBlob> result;
  for (const cv::KeyPoint& blob : blobs)
    result.push_back({Eigen::Vector2d(blob.pt.x, blob.pt.y), blob.size});
  return result;
}

}  // namespace tagcal::internal
