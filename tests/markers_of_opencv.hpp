#pragma once

// OpenCV's own drawings of markers and ChArUco boards, by either of its interfaces.
#if __has_include(<opencv2/objdetect/aruco_detector.hpp>)
#include <opencv2/objdetect/aruco_detector.hpp>
#else  // before OpenCV 4.7
#include <opencv2/aruco.hpp>
#include <opencv2/aruco/charuco.hpp>
#endif

namespace tagcal {

struct BoardOfOpenCv {
  std::vector<cv::Point3f> corners;  // of squares, inside the board
  std::vector<int> ids;              // of markers
  std::vector<std::vector<cv::Point3f>> markers;
  cv::Mat drawing;
};

struct SizesOfOpenCv {
  int columns, rows;
  float square, marker;
};

#if __has_include(<opencv2/objdetect/aruco_detector.hpp>)
inline cv::Mat marker_of_opencv(int dictionary, int id, int pixels) {
  cv::Mat drawing;
  cv::aruco::generateImageMarker(cv::aruco::getPredefinedDictionary(dictionary), id, pixels,
                                 drawing);
  return drawing;
}

inline BoardOfOpenCv charuco_of_opencv(const SizesOfOpenCv& sizes, int dictionary,
                                       int square_pixels) {
  const cv::aruco::CharucoBoard board({sizes.columns, sizes.rows}, sizes.square, sizes.marker,
                                      cv::aruco::getPredefinedDictionary(dictionary));
  BoardOfOpenCv b{board.getChessboardCorners(), board.getIds(), board.getObjPoints(), {}};
  board.generateImage({sizes.columns * square_pixels, sizes.rows * square_pixels}, b.drawing);
  return b;
}
#else
inline cv::Mat marker_of_opencv(int dictionary, int id, int pixels) {
  cv::Mat drawing;
  cv::aruco::drawMarker(cv::aruco::getPredefinedDictionary(dictionary), id, pixels, drawing);
  return drawing;
}

inline BoardOfOpenCv charuco_of_opencv(const SizesOfOpenCv& sizes, int dictionary,
                                       int square_pixels) {
  const auto board =
      cv::aruco::CharucoBoard::create(sizes.columns, sizes.rows, sizes.square, sizes.marker,
                                      cv::aruco::getPredefinedDictionary(dictionary));
  BoardOfOpenCv b{board->chessboardCorners, board->ids, board->objPoints, {}};
  board->draw({sizes.columns * square_pixels, sizes.rows * square_pixels}, b.drawing);
  return b;
}
#endif

}  // namespace tagcal
