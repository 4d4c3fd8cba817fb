#include "study/peers/opencv_views.hpp"

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/affine.hpp>
#include <optional>

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

namespace {

// A problem of no views, of one board, a square grid of points that are numbered row by row.
MrcalProblem empty_problem(const Dataset& dataset, double focal_px) {
  const auto points = target_points(dataset.boards[0].board);
  const int across = static_cast<int>(std::lround(std::sqrt(static_cast<double>(points.size()))));
  MrcalProblem problem;
  problem.width = dataset.image_size.width;
  problem.height = dataset.image_size.height;
  problem.grid_columns = problem.grid_rows = across;
  problem.spacing_m = (points[1].position - points[0].position).norm();
  problem.focal_px = focal_px;
  return problem;
}

// Adds the pixels of a view. Returns the pose of the grid by cv::solvePnP for a pinhole with the
// focal length.
cv::Affine3d add_mrcal_view(const View& view, const std::vector<TargetPoint>& points,
                            const MrcalView& place, MrcalProblem& problem) {
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
  problem.views.push_back(place);
  problem.pixels.insert(problem.pixels.end(), pixels.begin(), pixels.end());
  const cv::Matx33d k(problem.focal_px, 0, 0.5 * (problem.width - 1), 0, problem.focal_px,
                      0.5 * (problem.height - 1), 0, 0, 1);
  cv::Vec3d turn, move;
  cv::solvePnP(seen, at, k, cv::noArray(), turn, move);
  return {turn, move};
}

void append(const cv::Affine3d& pose, std::vector<double>& values) {
  const cv::Vec3d turn = pose.rvec(), move = pose.translation();
  values.insert(values.end(), {turn[0], turn[1], turn[2], move[0], move[1], move[2]});
}

}  // namespace

MrcalProblem mrcal_problem(const Dataset& dataset, double focal_px) {
  MrcalProblem problem = empty_problem(dataset, focal_px);
  const auto points = target_points(dataset.boards[0].board);
  for (const View& view : dataset.views) {
    const int frame = static_cast<int>(problem.poses.size() / 6);
    append(add_mrcal_view(view, points, {frame, 0}, problem), problem.poses);
  }
  return problem;
}

std::vector<double> calibrate_by_mrcal(const Dataset& dataset, double focal_px) {
  const std::array<double, 9> found =
      calibrate_by_mrcal(mrcal_problem(dataset, focal_px)).intrinsics.front();
  return {found.begin(), found.end()};
}

std::vector<Pose> calibrate_rig_by_mrcal(const RigDataset& rig, double focal_px) {
  MrcalProblem problem = empty_problem(rig.cameras.front().data, focal_px);
  problem.num_cameras = static_cast<int>(rig.cameras.size());
  const auto points = target_points(rig.cameras.front().data.boards[0].board);
  std::vector<std::optional<cv::Affine3d>> from_first(rig.cameras.size());
  for (const Instant& instant : rig.instants) {
    if (!instant.view[0]) continue;
    const int frame = static_cast<int>(problem.poses.size() / 6);
    std::optional<cv::Affine3d> in_first;
    for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
      if (!instant.view[c]) continue;
      const cv::Affine3d pose = add_mrcal_view(rig.cameras[c].data.views[*instant.view[c]], points,
                                               {frame, static_cast<int>(c)}, problem);
      if (!in_first) append(*(in_first = pose), problem.poses);
      if (!from_first[c]) from_first[c] = pose * in_first->inv();
    }
  }
  for (std::size_t c = 1; c < from_first.size(); ++c) {
    if (!from_first[c]) return {};
    append(*from_first[c], problem.camera_from_first);
  }
  const std::vector<double> found = calibrate_by_mrcal(problem).camera_from_first;
  std::vector<Pose> poses = {Pose()};
  for (std::size_t i = 0; i < found.size(); i += 6)
    poses.emplace_back(exp_rotation({found[i], found[i + 1], found[i + 2]}),
                       Eigen::Vector3d(found[i + 3], found[i + 4], found[i + 5]));
  return poses;
}

}  // namespace tagcal::study
