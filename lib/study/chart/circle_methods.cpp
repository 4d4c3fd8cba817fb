#include "study/chart/circle_methods.hpp"

#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>

#include "study/tasks/tag_view.hpp"
#include "tagcal/detect/detector.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector2d;

constexpr double kFocalPx = 530, kDistancePx = 24, kSpacing = 0.02;

std::vector<Observation> found_in(const Image8& image, const PlacedBoard& board,
                                  const Camera* camera) {
  DetectOptions options;
  options.camera = camera;
  return detect(image, {board}, options).view.observations;
}

// The claims of the fit under the true lens to a picture whose noise is large against the misfit of
// the model, in proportion to the noise of a pixel and its rounding.
constexpr double kNoiseOfBound = 8;
double bound_px(const CircleTask& task, const Image8& noisy, double noise_levels) {
  double sum = 0;
  const auto seen = found_in(noisy, task.board, &task.camera);
  for (const Observation& one : seen) sum += one.covariance_px2->trace() / 2;
  return std::sqrt(sum / static_cast<double>(seen.size()) *
                   (noise_levels * noise_levels + 1.0 / 12) /
                   (kNoiseOfBound * kNoiseOfBound + 1.0 / 12));
}

CircleMethod our_circles(bool lens_is_known) {
  const auto prepare = [=](const CircleTask& given) {
    return prepare_task<std::vector<Vector2d>>(given, [=](const CircleTask& task) {
      std::vector<Vector2d> centres;
      for (const Observation& seen :
           found_in(task.image, task.board, lens_is_known ? &task.camera : nullptr))
        centres.push_back(seen.pixel);
      return centres;
    });
  };
  return {lens_is_known ? "tagcal detect circles, lens known" : "tagcal detect circles", prepare,
          lens_is_known ? "--camera" : "the lens not known"};
}

CircleMethod opencv_circles() {
  const auto prepare = [](const CircleTask& given) {
    return prepare_task<std::vector<Vector2d>>(given, [](const CircleTask& task) {
      return circles_by_opencv(task.image, std::get<CircleGrid>(task.board.board.pattern));
    });
  };
  return {"OpenCV findCirclesGrid", prepare, "defaults"};
}

}  // namespace

std::vector<Vector2d> circles_by_opencv(const Image8& image, const CircleGrid& grid) {
  const cv::Mat pixels(image.height(), image.width(), CV_8U,
                       const_cast<std::uint8_t*>(image.pixels().data()));
  const int kind = grid.asymmetric ? cv::CALIB_CB_ASYMMETRIC_GRID : cv::CALIB_CB_SYMMETRIC_GRID;
  std::vector<cv::Point2f> found;
  std::vector<Vector2d> centres;
  if (cv::findCirclesGrid(pixels, {grid.columns, grid.rows}, found, kind))
    for (const cv::Point2f& centre : found) centres.emplace_back(centre.x, centre.y);
  return centres;
}

CircleTask draw_circle_task(double noise_levels, Random& random) {
  CircleGrid grid{8, 6, kSpacing, kSpacing / 2};
  Scene scene;
  scene.camera = {Perspective({kFocalPx, kFocalPx, 322, 238, -0.4, 0.18}), {640, 480}};
  scene.boards = {{make_board(grid), Pose()}};
  scene.paper_level = 220 / 255.0;
  scene.ink_level = 30 / 255.0;
  scene.sensor.blur_px = 0.8;
  scene.sensor.noise_levels = noise_levels;
  const std::vector<TargetPoint> points = target_points(scene.boards[0].board);
  const Eigen::Vector3d middle = (points.front().position + points.back().position) / 2;
  const double tilt_deg = random.uniform(0, 60);
  const Pose camera_from_tag = tag_pose(Eigen::Vector3d::UnitZ(), kSpacing * kFocalPx / kDistancePx,
                                        tilt_deg, random_turns(random));
  const Eigen::Vector3d middle_of_tag(0.5, 0.5, 0);
  const Pose camera_from_board =
      camera_from_tag * Pose(Eigen::Quaterniond::Identity(), middle_of_tag - middle);
  CircleTask task{scene.camera, scene.boards[0], {}, {}, 0};
  const ImageF light = render_light(scene, {}, camera_from_board);
  task.image = expose(light, scene.sensor, random.next());
  scene.sensor.noise_levels = kNoiseOfBound;
  for (const TargetPoint& point : points)
    task.centres[point.id.tag_id] =
        project(task.camera.lens, camera_from_board * point.position).value();
  task.bound_px = bound_px(task, expose(light, scene.sensor, random.next()), noise_levels);
  return task;
}

std::vector<CircleMethod> circle_methods() {
  return {our_circles(false), our_circles(true), opencv_circles()};
}

}  // namespace tagcal::study
