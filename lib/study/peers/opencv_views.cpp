#include "study/peers/opencv_views.hpp"

#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>

namespace tagcal::study {

OpenCvViews::OpenCvViews(const Dataset& dataset)
    : size(dataset.image_size.width, dataset.image_size.height) {
  const auto where = points_in_world(dataset.boards);
  for (const View& view : dataset.views) {
    if (view.observations.size() < 4) continue;
    points.emplace_back();
    pixels.emplace_back();
    for (const Observation& o : view.observations) {
      const Eigen::Vector3f x = where.at(o.id).cast<float>();
      const Eigen::Vector2f u = o.pixel.cast<float>();
      points.back().emplace_back(x.x(), x.y(), x.z());
      pixels.back().emplace_back(u.x(), u.y());
    }
  }
}

void OpenCvViews::calibrate(int flags) {
  k = distortion = cv::Mat();
  cv::calibrateCamera(points, pixels, size, k, distortion, turns, moves, deviations, cv::noArray(),
                      cv::noArray(), flags);
}

void OpenCvViews::calibrate_fisheye() {
  k = distortion = cv::Mat();
  cv::fisheye::calibrate(points, pixels, size, k, distortion, turns, moves,
                         cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW);
}

std::vector<double> OpenCvViews::values() const {
  std::vector<double> all = {k.at<double>(0, 0), k.at<double>(1, 1), k.at<double>(0, 2),
                             k.at<double>(1, 2)};
  for (int i = 0; i < static_cast<int>(distortion.total()); ++i)
    all.push_back(distortion.at<double>(i));
  return all;
}

MrcalProblem mrcal_problem(const Dataset& dataset, double focal_px) {
  const auto points = target_points(dataset.boards[0].board);
  const int across = static_cast<int>(std::lround(std::sqrt(static_cast<double>(points.size()))));
  const double spacing = (points[1].position - points[0].position).norm();
  const ImageSize& size = dataset.image_size;
  MrcalProblem problem{size.width, size.height, across, across, spacing, focal_px, {}, {}};
  const cv::Matx33d k(focal_px, 0, 0.5 * (size.width - 1), 0, focal_px, 0.5 * (size.height - 1), 0,
                      0, 1);
  for (const View& view : dataset.views) {
    std::vector<double> pixels;
    for (std::size_t i = 0; i < points.size(); ++i) pixels.insert(pixels.end(), {0, 0, -1});
    std::vector<cv::Point3d> seen;
    std::vector<cv::Point2d> at;
    for (const Observation& o : view.observations) {
      const auto i = static_cast<std::size_t>(o.id.tag_id);
      pixels[3 * i] = o.pixel.x(), pixels[3 * i + 1] = o.pixel.y(), pixels[3 * i + 2] = 1;
      // mrcal's grid starts at its first point.
      const Eigen::Vector3d x = points[i].position - points[0].position;
      seen.emplace_back(x.x(), x.y(), x.z());
      at.emplace_back(o.pixel.x(), o.pixel.y());
    }
    problem.pixels.insert(problem.pixels.end(), pixels.begin(), pixels.end());
    cv::Vec3d turn, move;
    cv::solvePnP(seen, at, k, cv::noArray(), turn, move);
    problem.poses.insert(problem.poses.end(),
                         {turn[0], turn[1], turn[2], move[0], move[1], move[2]});
  }
  return problem;
}

std::vector<double> calibrate_by_mrcal(const Dataset& dataset, double focal_px) {
  const std::array<double, 9> found = mrcal_intrinsics(mrcal_problem(dataset, focal_px));
  return {found.begin(), found.end()};
}

}  // namespace tagcal::study
