// Calibration of growing data sets against cv::calibrateCamera and, where it is installed, mrcal:
// the same 12 x 12 points, corners and model (opencv5: fx fy cx cy k1 k2 p1 p2 k3), plain least
// squares, one core each, total from corners in memory.
// - Ours: to camera, poses and all that `calibrate` says of its uncertainty.
// - OpenCV: to camera, poses and standard deviations, with its fastest solver (LU) and its default.
// - mrcal, as its own tool goes: the true focal length from the user, poses by cv::solvePnP, its
//   optimiser in three stages; no outliers looked for, no regularisation, no uncertainties.
// - mrcal's optimiser alone, all at once: poses and focal length for free.
// Each line: the median of the rounds in which all took turns.
//
//   calibrate_benchmark [rounds] [most views for OpenCV's default] [most views for ours]
//
// OpenCV's default solver takes time between the square and the cube of the views; beyond the
// given number of views it is left out, and it runs once.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#include "mrcal_peer.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "worlds.hpp"

namespace {

using tagcal::Dataset;

// Processor time: what else the machine does counts for nobody.
double seconds(const std::function<void()>& work) {
  const std::clock_t begin = std::clock();
  work();
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

constexpr int kGrid = 12;  // points across and down
constexpr double kSpacing = 0.06;
constexpr double kFocal = 900;

tagcal::Board grid_of_points() {
  tagcal::Board board;
  for (int i = 0; i < kGrid * kGrid; ++i)
    board.points.push_back({{i, 0}, {kSpacing * (i % kGrid), kSpacing * (i / kGrid), 0}});
  return board;
}

Dataset make_dataset(int num_views) {
  tagcal::WorldOptions options;
  options.num_views = num_views;
  options.sigma_px = 0.3;
  return tagcal::make_world(tagcal::opencv5_lens(), 1, options, grid_of_points());
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

tagcal::MrcalProblem mrcal_problem(const Dataset& dataset, const OpenCvInput& input) {
  tagcal::MrcalProblem problem{
      input.size.width, input.size.height, kGrid, kGrid, kSpacing, kFocal, {}, {}};
  const double cx = 0.5 * (input.size.width - 1), cy = 0.5 * (input.size.height - 1);
  const cv::Mat k = (cv::Mat_<double>(3, 3) << kFocal, 0, cx, 0, kFocal, cy, 0, 0, 1);
  for (std::size_t v = 0; v < dataset.views.size(); ++v) {
    std::vector<double> pixels;
    for (int i = 0; i < kGrid * kGrid; ++i) pixels.insert(pixels.end(), {0, 0, -1});
    for (const tagcal::Observation& o : dataset.views[v].observations) {
      double* corner = &pixels[static_cast<std::size_t>(3 * o.id.tag_id)];
      corner[0] = o.pixel.x(), corner[1] = o.pixel.y(), corner[2] = 1;
    }
    problem.pixels.insert(problem.pixels.end(), pixels.begin(), pixels.end());
    cv::Vec3d turn, move;
    cv::solvePnP(input.points[v], input.pixels[v], k, cv::noArray(), turn, move);
    problem.poses.insert(problem.poses.end(),
                         {turn[0], turn[1], turn[2], move[0], move[1], move[2]});
  }
  return problem;
}

struct Peers {
  bool fastest = false, standard = false, mrcal = false;
};

void print_peer(const char* name, std::vector<double> times, double ours, double focal,
                double our_focal) {
  if (times.empty()) return;
  const double t = median(std::move(times));
  std::printf("   %s %.3f s, %.1fx (f differs by %.0e)", name, t, t / ours,
              std::abs(focal - our_focal));
}

void line(int views, int rounds, const Peers& peers) {
  const Dataset dataset = make_dataset(views);
  const OpenCvInput input = opencv_input(dataset);
  tagcal::MrcalProblem problem;
  std::vector<double> our_times, fastest_times, standard_times, mrcal_times, optimiser_times;
  tagcal::Calibration ours;
  double fastest = 0, standard = 0, mrcal = 0, optimiser = 0;
  for (int i = 0; i < rounds; ++i) {
    our_times.push_back(seconds([&] {
      ours = tagcal::calibrate(dataset, {.model = "opencv5", .reject_outliers = false});
    }));
    if (peers.fastest)
      fastest_times.push_back(seconds([&] { fastest = opencv_focal(input, cv::CALIB_USE_LU); }));
    if (peers.mrcal) {
      mrcal_times.push_back(seconds([&] {
        problem = mrcal_problem(dataset, input);
        mrcal = mrcal_focal(problem, tagcal::MrcalStages::three);
      }));
      optimiser_times.push_back(
          seconds([&] { optimiser = mrcal_focal(problem, tagcal::MrcalStages::one); }));
    }
    if (peers.standard && i == 0)
      standard_times.push_back(seconds([&] { standard = opencv_focal(input, 0); }));
  }
  const double t = median(our_times), f = tagcal::parameters(ours.camera->lens)[0];
  std::printf("%6d views: %.4f s (start %.4f, solve %.4f, covariance %.4f; sd of f %.0e px)", views,
              t, ours.seconds.start, ours.seconds.solve, ours.seconds.covariance, ours.sigmas[0]);
  print_peer("mrcal", mrcal_times, t, mrcal, f);
  print_peer("its optimiser", optimiser_times, t, optimiser, f);
  print_peer("OpenCV LU", fastest_times, t, fastest, f);
  print_peer("OpenCV", standard_times, t, standard, f);
  std::printf("\n");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 5;
  const int most_default = argc > 2 ? std::atoi(argv[2]) : 50;
  const int most = argc > 3 ? std::atoi(argv[3]) : 1000;
  cv::setNumThreads(1);
  std::printf("OpenCV %s, mrcal %s, one core each\n", CV_VERSION,
              tagcal::has_mrcal() ? "2.2 or whichever is installed" : "not installed");
  for (const int views : {20, 50, 100, 200, 500, 1000, 2000, 5000, 10000})
    if (views <= most)
      line(views, views > 500 ? 3 : rounds,
           {views <= 200, views <= most_default, tagcal::has_mrcal() && views <= 1000});
}
