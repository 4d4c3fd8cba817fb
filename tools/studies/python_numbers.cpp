// Poses of single tags and projections of points with their times, for comparison with the Python
// module on the same numbers: python_overhead.py runs this study and prints the table. Writes
// float64 files of numbers and answers into a folder.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <span>
#include <vector>

#include "studies/studies.hpp"
#include "tagcal/camera/camera.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/random.hpp"

namespace tagcal {
using namespace study;
namespace {

constexpr int kTags = 2000;
constexpr int kPoints = 1'000'000;
constexpr int kRuns = 15;  // of which the fastest counts
constexpr double kNoise = 0.1;
constexpr double kHalfSide = 0.05;  // metres

template <typename Work>
double least_seconds(const Work& work) {
  double least = 1e9;
  for (int run = 0; run < kRuns; ++run) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    least = std::min(least, time.count());
  }
  return least;
}

void write(const std::filesystem::path& file, std::span<const double> values) {
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(values.data()),
            static_cast<std::streamsize>(values.size_bytes()));
}

// The corners of a tag seen from anywhere above it, in the order of cv::SOLVEPNP_IPPE_SQUARE.
std::vector<Correspondence> tag_view(const Camera& camera, Random& random) {
  const Pose camera_from_tag =
      camera_from_world_on_orbit({.distance_m = random.uniform(0.4, 1.5),
                                  .azimuth_rad = random.uniform(-3, 3),
                                  .elevation_rad = random.uniform(0.6, 1.5)});
  std::vector<Correspondence> corners;
  for (const auto& [x, y] : {std::pair{-1, 1}, {1, 1}, {1, -1}, {-1, -1}}) {
    const Eigen::Vector3d point(x * kHalfSide, y * kHalfSide, 0);
    const Eigen::Vector2d noise(kNoise * random.normal(), kNoise * random.normal());
    corners.push_back({point, *project(camera.lens, camera_from_tag * point) + noise});
  }
  return corners;
}

double time_poses(const std::filesystem::path& folder, const Camera& camera) {
  Random random(1);
  std::vector<std::vector<Correspondence>> tags(kTags);
  for (auto& tag : tags) tag = tag_view(camera, random);
  std::vector<PoseEstimate> estimates(kTags);
  const double seconds = least_seconds([&] {
    for (int i = 0; i < kTags; ++i)
      estimates[i] = estimate_pose(tags[i], camera, {.sigma_px = kNoise});
  });
  std::vector<double> pixels, answers;  // of each tag: matrix, covariance, all by columns
  for (int i = 0; i < kTags; ++i) {
    for (const Correspondence& c : tags[i])
      pixels.insert(pixels.end(), c.pixel.data(), c.pixel.data() + 2);
    const Eigen::Matrix4d matrix = estimates[i].camera_from_target().matrix();
    const Matrix6& covariance = estimates[i].hypotheses.front().covariance;
    answers.insert(answers.end(), matrix.data(), matrix.data() + matrix.size());
    answers.insert(answers.end(), covariance.data(), covariance.data() + covariance.size());
  }
  write(folder / "tag_pixels.f64", pixels);
  write(folder / "tag_answers.f64", answers);
  return 1e6 * seconds / kTags;
}

double time_projection(const std::filesystem::path& folder, const Camera& camera) {
  Random random(2);
  std::vector<Eigen::Vector3d> points(kPoints);
  for (Eigen::Vector3d& p : points)
    p = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-0.1, 4)};
  std::vector<Eigen::Vector2d> pixels(kPoints);
  std::vector<std::uint8_t> valid(kPoints);
  const double seconds =
      least_seconds([&] { project(camera.lens, Pose(), points, pixels, valid); });
  write(folder / "points.f64", {points.front().data(), 3 * points.size()});
  write(folder / "pixels.f64", {pixels.front().data(), 2 * pixels.size()});
  return 1e3 * seconds;
}

}  // namespace

Study python_numbers_study() {
  const auto tasks = [](const StudyOptions& options) {
    const std::filesystem::path folder = options.inputs.front();
    const Camera camera{Perspective({700, 705, 330, 236, -0.2, 0.06, 0.001, -0.0005}), {640, 480}};
    const auto task = [&](const char* name, auto time) {
      return Task{name, [=](std::uint64_t) { return std::vector<Values>{{time(folder, camera)}}; },
                  1};
    };
    return std::vector<Task>{task("pose, us a tag", time_poses),
                             task("project, ms", time_projection)};
  };
  return {.name = "python_numbers",
          .summary = "numbers, answers and times for tools/studies/python_overhead.py",
          .inputs = "folder to write to",
          .count = 1,
          .columns = {"time"},
          .tasks = tasks,
          .tables = {{{"task"}, {sum_of("time", "time", 4)}}}};
}

}  // namespace tagcal
