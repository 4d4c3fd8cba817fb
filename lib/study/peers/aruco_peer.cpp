#include "study/peers/tag_peers.hpp"

#ifdef TAGCAL_HAS_ARUCO

#include <cstdio>
#include <opencv2/aruco.hpp>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgcodecs.hpp>

namespace tagcal::study {
namespace {

cv::Mat as_mat(const Image8& image) {
  return {image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.row(0))};
}

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
  return tags_in(as_mat(image), border_bits);
}

std::vector<PeerTag> aruco_tags(const std::filesystem::path& file, int border_bits) {
  return tags_in(cv::imread(file.string(), cv::IMREAD_GRAYSCALE), border_bits);
}

std::vector<Eigen::Vector2d> charuco_corners(const Image8& image, const Charuco& board) {
  // DICT_4X4_50, _100, _250, _1000, DICT_5X5_50 and so on count from 0.
  int side = 0, count = 0;
  if (std::sscanf(board.dictionary.c_str(), "DICT_%1dX%*1d_%d", &side, &count) != 2) return {};
  const int number = 4 * (side - 4) + (count > 50) + (count > 100) + (count > 250);
  const auto codes = cv::aruco::getPredefinedDictionary(number);
  const auto theirs = cv::aruco::CharucoBoard::create(board.square_columns, board.square_rows,
                                                      static_cast<float>(board.square_size),
                                                      static_cast<float>(board.marker_size), codes);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> ids, corner_ids;
  std::vector<cv::Point2f> corners;
  cv::aruco::detectMarkers(as_mat(image), codes, markers, ids);
  if (!ids.empty())
    cv::aruco::interpolateCornersCharuco(markers, ids, as_mat(image), theirs, corners, corner_ids);
  std::vector<Eigen::Vector2d> found;
  for (const cv::Point2f& corner : corners) found.emplace_back(corner.x, corner.y);
  return found;
}

}  // namespace tagcal::study

#else

namespace tagcal::study {

bool has_aruco() { return false; }
std::vector<PeerTag> aruco_tags(const Image8&, int) { return {}; }
std::vector<PeerTag> aruco_tags(const std::filesystem::path&, int) { return {}; }
std::vector<Eigen::Vector2d> charuco_corners(const Image8&, const Charuco&) { return {}; }

}  // namespace tagcal::study

#endif
