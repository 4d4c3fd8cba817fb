#include "checker_pictures.hpp"

#include <algorithm>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "study/peers/tag_peers.hpp"
#include "study/processor_time.hpp"
#include "tagcal/detect/detector.hpp"

namespace tagcal {
using namespace study;
namespace {

using Eigen::Vector2d;

cv::Mat as_mat(const Image8& image) {
  return {image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.row(0))};
}

std::vector<Vector2d> as_places(const std::vector<cv::Point2f>& points) {
  std::vector<Vector2d> places;
  for (const cv::Point2f& point : points) places.emplace_back(point.x, point.y);
  return places;
}

// Distance to the nearest other place.
double nearest_px(const std::vector<Vector2d>& places) {
  double least = std::numeric_limits<double>::max();
  for (const Vector2d& a : places)
    for (const Vector2d& b : places)
      if (&a != &b) least = std::min(least, (a - b).norm());
  return least;
}

std::vector<Vector2d> by_quads(const Image8& image, const Checkerboard& board) {
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCorners(as_mat(image), {board.columns, board.rows}, corners)) return {};
  const std::vector<Vector2d> starts = as_places(corners);
  return corners_by_sub_pix(image, starts, nearest_px(starts));
}

std::vector<Vector2d> places_by_sectors(const Image8& image, const Checkerboard& board) {
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCornersSB(as_mat(image), {board.columns, board.rows}, corners,
                                   cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY))
    return {};
  return as_places(corners);
}

}  // namespace

FoundCorners corners_by_fit(const Image8& image, const Board& board, const Camera* camera,
                            Refinement refinement) {
  DetectOptions options;
  options.threads = 1;
  options.camera = camera;
  options.refinement = refinement;
  FoundCorners found;
  Lap lap;
  found.view = detect(image, {{board, Pose()}}, options).view;
  found.ms = 1e3 * lap();
  return found;
}

std::vector<Vector2d> corners_by_sub_pix(const Image8& image, const std::vector<Vector2d>& starts,
                                         double square_px) {
  std::vector<cv::Point2f> corners;
  for (const Vector2d& at : starts)
    corners.emplace_back(static_cast<float>(at.x()), static_cast<float>(at.y()));
  const int half = std::max(2, static_cast<int>(std::min(5.0, square_px / 3)));
  cv::cornerSubPix(as_mat(image), corners, {half, half}, {-1, -1},
                   {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 40, 1e-3});
  return as_places(corners);
}

std::vector<PeerDetector> peer_detectors(const Board& board) {
  if (const auto* charuco = std::get_if<Charuco>(&board.pattern))
    return {{"interpolateCornersCharuco",
             [board = *charuco](const Image8& image) { return charuco_corners(image, board); }}};
  const Checkerboard squares = checkers(board).value();
  return {{"findChessboardCorners",
           [squares](const Image8& image) { return by_quads(image, squares); }},
          {"findChessboardCornersSB",
           [squares](const Image8& image) { return places_by_sectors(image, squares); }}};
}

FoundCorners corners_by_peer(const PeerDetector& peer, const Image8& image,
                             const ExactCorners& exact) {
  FoundCorners found;
  Lap lap;
  const std::vector<Vector2d> corners = peer.find(image);
  found.ms = 1e3 * lap();
  for (const Vector2d& at : corners) {
    const auto nearest =
        std::ranges::min_element(exact, {}, [&](const auto& c) { return (c.second - at).norm(); });
    found.view.observations.push_back(
        {nearest == exact.end() ? CornerId{} : nearest->first, at, {}});
  }
  return found;
}

}  // namespace tagcal
