// Batch projection against cv::projectPoints: the same camera, pose and points, double precision,
// one core, outputs allocated before. Both take turns, round by round, and each round gives one
// ratio: what else the machine does then falls on both.
//
//   project_benchmark [points] [rounds]

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#include "tagcal/camera/batch.hpp"
#include "tagcal/random.hpp"

namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const Vector3d kTurn(0.1, -0.2, 0.05);
const Vector3d kTranslation(0.1, -0.05, 0.2);
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// One set of points and what ours writes.
struct Ours {
  explicit Ours(std::size_t n, std::size_t columns)
      : pixels(n), valid(n), by_pose(12 * n), by_parameters(2 * columns * n) {
    tagcal::Random random(1);
    for (std::size_t i = 0; i < n; ++i) {
      const double z = random.uniform(1, 3);
      points.emplace_back(z * random.uniform(-0.4, 0.4), z * random.uniform(-0.3, 0.3), z);
    }
  }

  std::vector<Vector3d> points;
  std::vector<Vector2d> pixels;
  std::vector<std::uint8_t> valid;
  std::vector<double> by_pose, by_parameters;
};

// The same for OpenCV.
struct Theirs {
  Theirs(const Ours& ours, const std::vector<double>& p)
      : k(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1), pixels(ours.points.size()) {
    for (const Vector3d& x : ours.points) points.emplace_back(x.x(), x.y(), x.z());
    distortion = cv::Mat1d(1, static_cast<int>(p.size()) - 4);
    for (int i = 0; i < distortion.cols; ++i) distortion(i) = p[static_cast<std::size_t>(i) + 4];
  }

  std::vector<cv::Point3d> points;
  cv::Matx33d k;
  cv::Mat1d distortion;  // empty: none
  cv::Vec3d turn{kTurn.x(), kTurn.y(), kTurn.z()};
  cv::Vec3d translation{kTranslation.x(), kTranslation.y(), kTranslation.z()};
  std::vector<cv::Point2d> pixels;
  cv::Mat jacobian;
};

// Of the processor's time, which other programs do not take part in.
double nanoseconds(const std::function<void()>& work, int repeats) {
  const std::clock_t begin = std::clock();
  for (int i = 0; i < repeats; ++i) work();
  return 1e9 / CLOCKS_PER_SEC * static_cast<double>(std::clock() - begin) / repeats;
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

struct Contest {
  std::string name;
  std::function<void()> ours, theirs;
  double difference_px = 0;        // the largest of pixels
  double difference_jacobian = 0;  // the largest of a column, relative to the column's norm
  double mark = 0;                 // ratio asked for; 0: none
};

void race(const Contest& contest, std::size_t n, int rounds) {
  // Rounds of about two milliseconds, so that both see the same machine.
  const auto repeats = [](const std::function<void()>& work) {
    return 1 + static_cast<int>(2e6 / std::max(nanoseconds(work, 30), 1.0));
  };
  const int repeats_ours = repeats(contest.ours), repeats_theirs = repeats(contest.theirs);
  std::vector<double> ours, theirs, ratios;
  for (int i = 0; i < rounds; ++i) {
    const bool first = i % 2 == 0;
    const double a = first ? nanoseconds(contest.ours, repeats_ours) : 0;
    theirs.push_back(nanoseconds(contest.theirs, repeats_theirs) / static_cast<double>(n));
    const double b = first ? a : nanoseconds(contest.ours, repeats_ours);
    ours.push_back(b / static_cast<double>(n));
    ratios.push_back(theirs.back() / ours.back());
  }
  std::printf("%-28s %8.2f %9.2f %8.1f  (%.1f to %.1f)  %9.1e %9.1e", contest.name.c_str(),
              quantile(ours, 0.5), quantile(theirs, 0.5), quantile(ratios, 0.5),
              quantile(ratios, 0.1), quantile(ratios, 0.9), contest.difference_px,
              contest.difference_jacobian);
  if (contest.mark > 0) std::printf("  mark %.0f", contest.mark);
  std::printf("\n");
}

double largest_difference_px(const Ours& ours, const Theirs& theirs) {
  double largest = 0;
  for (std::size_t i = 0; i < ours.points.size(); ++i)
    largest = std::max(largest,
                       (ours.pixels[i] - Vector2d(theirs.pixels[i].x, theirs.pixels[i].y)).norm());
  return largest;
}

// OpenCV's columns are rotation vector, translation, fx fy cx cy, distortion; our step turns on the
// left of the rotation, so J_rotation_vector = J_omega * left_jacobian.
double largest_difference_jacobian(const Ours& ours, const Theirs& theirs) {
  const auto rows = static_cast<Eigen::Index>(2 * ours.points.size());
  const Eigen::Index k = static_cast<Eigen::Index>(ours.by_parameters.size()) / rows;
  RowMajor mine(rows, 6 + k);
  mine << Eigen::Map<const RowMajor>(ours.by_pose.data(), rows, 6),
      Eigen::Map<const RowMajor>(ours.by_parameters.data(), rows, k);
  mine.leftCols<3>() = (mine.leftCols<3>() * tagcal::left_jacobian(kTurn)).eval();
  const Eigen::Map<const RowMajor> other(theirs.jacobian.ptr<double>(), rows, 6 + k);
  double largest = 0;
  for (Eigen::Index i = 0; i < mine.cols(); ++i)
    largest = std::max(largest, (mine.col(i) - other.col(i)).norm() / other.col(i).norm());
  return largest;
}

struct Lens {
  std::string name;
  tagcal::Lens lens;
  std::vector<double> cv_parameters;
  std::string model;  // whose free parameters are the columns; empty: pixels only
  double mark;
};

void race_perspective(const Lens& lens, std::size_t n, int rounds) {
  const tagcal::Pose pose(tagcal::exp_rotation(kTurn), kTranslation);
  std::vector<tagcal::FreeParameter> free;
  if (!lens.model.empty()) free = tagcal::Model::named(lens.model).free();
  Ours a(n, free.size());
  Theirs b(a, lens.cv_parameters);
  Contest contest{lens.name};
  contest.mark = lens.mark;
  if (lens.model.empty()) {
    contest.ours = [&] { tagcal::project(lens.lens, pose, a.points, a.pixels, a.valid); };
    contest.theirs = [&] {
      cv::projectPoints(b.points, b.turn, b.translation, b.k, b.distortion, b.pixels);
    };
  } else {
    contest.ours = [&] {
      tagcal::project_with_jacobians(lens.lens, pose, a.points, free,
                                     {a.pixels, a.valid, a.by_pose, a.by_parameters});
    };
    contest.theirs = [&] {
      cv::projectPoints(b.points, b.turn, b.translation, b.k, b.distortion, b.pixels, b.jacobian);
    };
  }
  contest.ours();
  contest.theirs();
  contest.difference_px = largest_difference_px(a, b);
  if (!free.empty()) contest.difference_jacobian = largest_difference_jacobian(a, b);
  race(contest, n, rounds);
}

void race_fisheye(const Lens& lens, std::size_t n, int rounds) {
  const tagcal::Pose pose(tagcal::exp_rotation(kTurn), kTranslation);
  Ours a(n, 0);
  Theirs b(a, lens.cv_parameters);
  Contest contest{lens.name};
  contest.ours = [&] { tagcal::project(lens.lens, pose, a.points, a.pixels, a.valid); };
  contest.theirs = [&] {
    cv::fisheye::projectPoints(b.points, b.pixels, b.turn, b.translation, b.k, b.distortion);
  };
  contest.ours();
  contest.theirs();
  contest.difference_px = largest_difference_px(a, b);
  race(contest, n, rounds);
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t n = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 10000;
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 101;
  if (n == 0 || rounds <= 0) {
    std::fprintf(stderr, "usage: project_benchmark [points] [rounds]\n");
    return 2;
  }
  cv::setNumThreads(1);
  // Large arrays that all begin at the border of a page are slow to read and write in turns (4 KiB
  // aliasing); after one large block was freed, glibc places the following in the heap instead.
  std::vector<char>(16 << 20).shrink_to_fit();
  std::printf(
      "%zu points, %d rounds, OpenCV %s, one thread; ns a point, medians; ratio with 10 %% "
      "and 90 %% quantiles;\nlargest difference of pixels (px) and of a Jacobian's column "
      "(relative)\n",
      n, rounds, CV_VERSION);
  std::printf("%-28s %8s %9s %8s\n", "", "tagcal", "OpenCV", "ratio");

  const std::vector<double> pinhole = {800, 810, 640, 400};
  const std::vector<double> opencv5 = {800, 810, 640, 400, -0.28, 0.07, 1e-3, -5e-4, 2e-3};
  const std::vector<double> opencv8 = {800,  810,   640,  400,  0.2,  -0.1,
                                       1e-3, -5e-4, 2e-3, 0.35, 0.05, 0.01};
  const std::vector<double> fisheye4 = {400, 405, 640, 400, -0.01, 0.02, -0.01, 0.002};
  const auto perspective = [](const std::vector<double>& p) {
    tagcal::Perspective::Parameters all = {};
    std::copy(p.begin(), p.end(), all.begin());
    return tagcal::Perspective(all);
  };
  race_perspective({"pinhole", perspective(pinhole), pinhole, "", 10}, n, rounds);
  race_perspective({"opencv5", perspective(opencv5), opencv5, "", 8}, n, rounds);
  race_perspective({"opencv5, 15 columns", perspective(opencv5), opencv5, "opencv5", 10}, n,
                   rounds);
  race_perspective({"opencv8", perspective(opencv8), opencv8, "", 0}, n, rounds);
  race_perspective({"opencv8, 18 columns", perspective(opencv8), opencv8, "opencv8", 0}, n, rounds);
  tagcal::Fisheye::Parameters f;
  std::copy(fisheye4.begin(), fisheye4.end(), f.begin());
  race_fisheye({"fisheye4", tagcal::Fisheye(f), fisheye4, "", 0}, n, rounds);
  return 0;
}
