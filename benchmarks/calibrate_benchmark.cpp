// Calibration of growing data sets against cv::calibrateCamera: the same boards, corners and model
// (opencv5: fx fy cx cy k1 k2 p1 p2 k3), plain least squares, one core, total from corners in
// memory to camera, poses and standard deviations. Each line: the median of the rounds in which
// both took turns.
//
//   calibrate_benchmark [rounds] [most views for OpenCV's default] [most views for ours]
//
// OpenCV's default solver takes time between the square and the cube of the views; beyond the
// given number of views it is left out.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#include "tagcal/estimate/calibrate.hpp"
#include "worlds.hpp"

namespace {

using tagcal::Dataset;

double seconds(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

struct OpenCvInput {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  cv::Size size;
};

OpenCvInput opencv_input(const Dataset& dataset) {
  OpenCvInput input;
  input.size = {dataset.image_size.width, dataset.image_size.height};
  const auto places = tagcal::points_in_world(dataset.boards);
  for (const tagcal::View& view : dataset.views) {
    input.points.emplace_back();
    input.pixels.emplace_back();
    for (const tagcal::Observation& o : view.observations) {
      const Eigen::Vector3f x = places.at(o.id).cast<float>();
      const Eigen::Vector2f u = o.pixel.cast<float>();
      input.points.back().emplace_back(x.x(), x.y(), x.z());
      input.pixels.back().emplace_back(u.x(), u.y());
    }
  }
  return input;
}

double opencv_focal(const OpenCvInput& input, int flags) {
  cv::Mat k, distortion, deviations;
  std::vector<cv::Mat> turns, moves;
  cv::calibrateCamera(input.points, input.pixels, input.size, k, distortion, turns, moves,
                      deviations, cv::noArray(), cv::noArray(), flags);
  return k.at<double>(0, 0);
}

struct Times {
  std::vector<double> ours, fastest, standard;
};

void line(int views, int rounds, bool with_opencv, bool with_default) {
  tagcal::WorldOptions options;
  options.num_views = views;
  options.sigma_px = 0.3;
  const Dataset dataset = tagcal::make_world(tagcal::opencv5_lens(), 1, options);
  const OpenCvInput input = opencv_input(dataset);
  Times times;
  tagcal::Calibration ours;
  double focal = 0;
  for (int i = 0; i < rounds; ++i) {
    times.ours.push_back(seconds([&] {
      ours = tagcal::calibrate(dataset, {.model = "opencv5", .reject_outliers = false});
    }));
    if (with_opencv)
      times.fastest.push_back(seconds([&] { focal = opencv_focal(input, cv::CALIB_USE_LU); }));
    if (with_default && i == 0)
      times.standard.push_back(seconds([&] { focal = opencv_focal(input, 0); }));
  }
  const double t = median(times.ours);
  std::printf("%6d %9.4f s (start %.4f solve %.4f covariance %.4f, %d iterations)", views, t,
              ours.seconds.start, ours.seconds.solve, ours.seconds.covariance, ours.num_iterations);
  if (with_opencv) {
    const double lu = median(times.fastest);
    std::printf("   LU %8.3f s %6.1fx", lu, lu / t);
  }
  if (with_default)
    std::printf("   default %8.3f s %7.1fx", times.standard[0], times.standard[0] / t);
  if (with_opencv)
    std::printf("   f differs by %.1e px (sd %.1e)",
                std::abs(focal - tagcal::parameters(ours.camera->lens)[0]), ours.sigmas[0]);
  std::printf("\n");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 5;
  const int most_default = argc > 2 ? std::atoi(argv[2]) : 50;
  const int most = argc > 3 ? std::atoi(argv[3]) : 1000;
  cv::setNumThreads(1);
  std::printf("OpenCV %s, one core each\n", CV_VERSION);
  for (const int views : {20, 50, 100, 200, 500, 1000, 2000, 5000, 10000})
    if (views <= most) line(views, views > 500 ? 1 : rounds, views <= 200, views <= most_default);
}
