#include "study/peers/aruco_peer.hpp"

#ifdef TAGCAL_HAS_ARUCO

#include <opencv2/aruco.hpp>
#include <opencv2/imgcodecs.hpp>

namespace tagcal::study {
namespace {

std::vector<PeerTag> tags_in(const cv::Mat& image, int border_bits) {
  const auto codes = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11);
  const auto options = cv::aruco::DetectorParameters::create();
  options->markerBorderBits = border_bits;
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(image, codes, corners, ids, options);
  std::vector<PeerTag> tags;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    PeerTag tag;
    tag.id = ids[i];
    for (std::size_t k = 0; k < 4; ++k) {  // clockwise, from the one opposite to our second
      const cv::Point2f& corner = corners[i][(5 - k) % 4];
      tag.corners[k] = {corner.x, corner.y};
    }
    tags.push_back(tag);
  }
  return tags;
}

}  // namespace

bool has_aruco() { return true; }

std::vector<PeerTag> aruco_tags(const Image8& image, int border_bits) {
  return tags_in(
      cv::Mat(image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.row(0))),
      border_bits);
}

std::vector<PeerTag> aruco_tags(const std::filesystem::path& file, int border_bits) {
  return tags_in(cv::imread(file.string(), cv::IMREAD_GRAYSCALE), border_bits);
}

}  // namespace tagcal::study

#else

namespace tagcal::study {

bool has_aruco() { return false; }
std::vector<PeerTag> aruco_tags(const Image8&, int) { return {}; }
std::vector<PeerTag> aruco_tags(const std::filesystem::path&, int) { return {}; }

}  // namespace tagcal::study

#endif
