// How accurate the corners of single tags are: this library's fit, its edges and AprilTag's own
// corners on the same rendered pixels, beside the Cramer-Rao bound of the fitted model.
//   corner_accuracy [tags per row, default 200]

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <numbers>
#include <vector>

#include "tagcal/detect/families.hpp"
#include "tagcal/detect/refine_tag.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/render.hpp"

namespace {

using namespace tagcal;
using Corners = std::array<Eigen::Vector2d, 4>;

constexpr double kFocal = 900;

struct Row {
  double side_px, tilt_deg, blur_px, noise_levels, table_bound_px;
};

constexpr Row kRows[] = {
    {20, 30, .8, 2, .0122}, {30, 30, .8, 2, .0081}, {40, 30, .8, 2, .0066}, {80, 30, .8, 2, .0045},
    {160, 30, .8, 2, .0032}, {40, 0, .8, 2, .0062}, {40, 60, .8, 2, .0098}, {40, 30, .3, 2, .0044},
    {40, 30, 1.5, 2, .0107}, {40, 30, .8, 0, .0009}, {40, 30, .8, 8, .026}};

struct View {
  Scene scene;
  Pose camera_from_world;
  Corners corners;
  int id;
};

View view_of(const Row& row, Random& random) {
  View view;
  const int width = static_cast<int>(1.7 * row.side_px) + 24;
  view.id = static_cast<int>(random.index(587));
  Board board;
  board.border_bits = 1;
  board.corner_squares = false;
  board.tags.push_back({view.id, 1.0, Pose()});
  view.scene.boards.push_back({board, Pose()});
  const double middle = 0.5 * (width - 1);
  const Lens lens = pinhole(kFocal, kFocal, middle + random.uniform(-0.5, 0.5),
                            middle + random.uniform(-0.5, 0.5));
  view.scene.camera = {lens, {width, width}};
  view.scene.sensor = {1, row.blur_px, row.noise_levels};
  view.scene.paper_level = 220 / 255.0;
  view.scene.ink_level = 30 / 255.0;
  view.scene.paper_margin_m = 2;
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  const Eigen::Vector3d axis(std::cos(azimuth), std::sin(azimuth), 0);
  const Eigen::AngleAxisd tilt(row.tilt_deg * std::numbers::pi / 180, axis);
  const Eigen::AngleAxisd roll(random.uniform(0, 2 * std::numbers::pi), Eigen::Vector3d::UnitZ());
  const Eigen::AngleAxisd over(std::numbers::pi, Eigen::Vector3d::UnitX());
  view.camera_from_world =
      Pose(Eigen::Quaterniond(tilt * roll * over), Eigen::Vector3d(0, 0, kFocal / row.side_px));
  const auto corners = tag_corners(board.tags[0]);
  for (std::size_t i = 0; i < 4; ++i)
    view.corners[i] = *project(view.scene.camera.lens, view.camera_from_world * corners[i]);
  return view;
}

struct Sums {
  int tags = 0, missed = 0, iterations = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  std::vector<double> seconds;
  double outwards = 0, squares = 0, predicted = 0, bound = 0, nees = 0, blur = 0, noise=0;

  void add(const TagFit& fit, const TagFit& exact, const View& view, double exact_scale) {
    ++tags;
    iterations += fit.iterations;
    const Eigen::Vector2d centre =
        (view.corners[0] + view.corners[1] + view.corners[2] + view.corners[3]) / 4;
    Eigen::Matrix<double, 8, 1> error;
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector2d e = fit.corners[i] - view.corners[i];
      error.segment<2>(2 * static_cast<Eigen::Index>(i)) = e;
      mean += e;
      outwards += e.dot((view.corners[i] - centre).normalized());
    }
    squares += error.squaredNorm();
    predicted += fit.covariance_px2.trace();
    bound += exact.covariance_px2.trace() * exact_scale;
    nees += error.dot(fit.covariance_px2.ldlt().solve(error)) / 8;
    blur += fit.blur_px;
    noise += fit.noise_levels;
  }
};

void run(const Row& row, int count) {
  const TagFamilies families = {{"tag36h11", tag_family("tag36h11", 1)}};
  Random random(9090);
  Sums sums;
  for (int i = 0; i < count; ++i) {
    const View view = view_of(row, random);
    const ImageF light = render_light(view.scene, families, view.camera_from_world);
    const Image8 image = expose(light, view.scene.sensor, random.next());
    Sensor exact_sensor = view.scene.sensor;
    exact_sensor.noise_levels = 0;
    const Image8 noiseless = expose(light, exact_sensor, 0);
    const TagPattern pattern = tag_pattern(families.at("tag36h11"), view.id, 1);
    TagFitOptions options;
    if (const char* bend = std::getenv("BEND")) options.bend_sd_per_px = std::atof(bend), options.twist_sd_per_px2 = options.bend_sd_per_px / 150;
    const TagFit exact = refine_tag(noiseless, pattern, view.corners, options);
    Corners start = view.corners;
    for (auto& corner : start)
      corner += Eigen::Vector2d(random.uniform(-.2, .2), random.uniform(-.2, .2));
    const std::clock_t begin = std::clock();
    const TagFit fit = refine_tag(image, pattern, start, options);
    sums.seconds.push_back(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    if (fit.status != TagFitStatus::converged || exact.status != TagFitStatus::converged) {
      ++sums.missed;
      if (sums.missed < 4) std::printf("status %d %d pixels %d noise %g exact noise %g white %g black %g it %d\n", int(fit.status), int(exact.status), fit.num_pixels, fit.noise_levels, exact.noise_levels, fit.white, fit.black, fit.iterations);
      continue;
    }
    const double noise = row.noise_levels * row.noise_levels + 1.0 / 12;
    sums.add(fit, exact, view, noise / (exact.noise_levels * exact.noise_levels));
    if (i < 2 && std::getenv("VERBOSE")) std::printf("exact: noise %g blur %g err %g\n", exact.noise_levels / 200, exact.blur_px, (exact.corners[0] - view.corners[0]).norm());
  }
  const double n = 8.0 * sums.tags;
  std::ranges::nth_element(sums.seconds, sums.seconds.begin() + count / 2);
  const double median = sums.seconds[static_cast<std::size_t>(count / 2)];
  const double rms = std::sqrt(sums.squares / n);
  std::printf("%4.0f %3.0f %4.1f %4.1f | rms %.4f bound %.4f ratio %.3f table %.4f ratio %.2f | mean %+.4f %+.4f out %+.4f | sd pred/obs %.3f nees %.3f | %.3f ms, %.1f it, missed %d blur %.3f noise %.2f\n",
              row.side_px, row.tilt_deg, row.blur_px, row.noise_levels, rms, std::sqrt(sums.bound / n),
              rms / std::sqrt(sums.bound / n), row.table_bound_px, rms / row.table_bound_px,
              sums.mean.x() * 2 / n, sums.mean.y() * 2 / n, sums.outwards * 2 / n,
              std::sqrt(sums.predicted / n) / rms, sums.nees / sums.tags, 1e3 * median,
              double(sums.iterations) / sums.tags, sums.missed, sums.blur/sums.tags, sums.noise/sums.tags);
}

}  // namespace

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 200;
  const int only = argc > 2 ? std::atoi(argv[2]) : -1;
  for (int i = 0; i < static_cast<int>(std::size(kRows)); ++i)
    if (only < 0 || i == only) run(kRows[i], count);
  return 0;
}
