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
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/study/calibration_tasks.hpp"

namespace {

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

tagcal::CalibrationTask make_task(int num_views) {
  tagcal::Random random(1);
  return tagcal::draw_calibration(
      tagcal::Perspective({900, 898, 651, 392, -0.15, 0.05, 5e-4, -3e-4, 0}), "opencv5", num_views,
      random);
}

struct Peer {
  std::string title;
  tagcal::CalibrationMethod method;
  int rounds = 0;
  std::vector<double> times = {};
  double focal = 0;
};

void run(Peer& peer, const tagcal::CalibrationTask& task) {
  const auto prepared = peer.method.prepare(task);
  peer.times.push_back(seconds(prepared.solve));
  peer.focal = prepared.answer()[0];
}

// Of the given number of views.
std::vector<Peer> peers_for(int views, int rounds, int most_default) {
  std::vector<Peer> peers;
  for (const tagcal::CalibrationMethod& m : tagcal::calibration_methods("opencv5")) {
    if (m.name == "mrcal" && views <= 1000) {
      peers.push_back({"mrcal", m, rounds});
      peers.push_back(
          {"its optimiser", tagcal::mrcal_calibration(tagcal::MrcalStages::one), rounds});
    } else if (m.name.ends_with("LU") && views <= 200) {
      peers.push_back({"OpenCV LU", m, rounds});
    } else if (m.name == "OpenCV calibrateCamera" && views <= most_default) {
      peers.push_back({"OpenCV", m, 1});
    }
  }
  return peers;
}

void line(int views, int rounds, std::vector<Peer> peers) {
  const tagcal::CalibrationTask task = make_task(views);
  std::vector<double> our_times;
  tagcal::Calibration ours;
  for (int i = 0; i < rounds; ++i) {
    our_times.push_back(seconds([&] {
      ours = tagcal::calibrate(task.dataset, {.model = "opencv5", .reject_outliers = false});
    }));
    for (Peer& peer : peers)
      if (i < peer.rounds) run(peer, task);
  }
  const double t = median(our_times), f = tagcal::parameters(ours.camera->lens)[0];
  std::printf("%6d views: %.4f s (start %.4f, solve %.4f, covariance %.4f; sd of f %.0e px)", views,
              t, ours.seconds.start, ours.seconds.solve, ours.seconds.covariance, ours.sigmas[0]);
  for (const Peer& peer : peers) {
    const double theirs = median(peer.times);
    std::printf("   %s %.3f s, %.1fx (f differs by %.0e)", peer.title.c_str(), theirs, theirs / t,
                std::abs(peer.focal - f));
  }
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
    if (views <= most) {
      const int turns = views > 500 ? 3 : rounds;
      line(views, turns, peers_for(views, turns, most_default));
    }
}
