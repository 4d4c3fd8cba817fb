// Measures the speed of the renderer and the error of its levels.
//
//   render_benchmark [rounds, default 31 [samples, default 64]]
//
// Speed: processor time of one thread, medians; a picture of `tagcal render` takes the sum of a
// view, expose and write_png. Error: on one of 16 pixels that an edge crosses, against the mean of
// `samples` x `samples` rays, which do not use the renderer: from the pixel through `ray_in_camera`
// to the board's plane, and there by arithmetic to the tag and its bit. The error of 16 x 16 rays
// against the same reference is printed beside it as the mark.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tagcal/detect/families.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/scene/render.hpp"

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTagSize = 0.088, kSpacing = 0.3;
constexpr int kOneOf = 16;  // the error is measured at one of so many edge pixels

struct View {
  std::string name;
  tagcal::Scene scene;
  tagcal::Pose camera_from_world;
};

tagcal::TagFamilies families() { return {{"tag36h11", tagcal::tag_family("tag36h11", 2)}}; }

// Kalibr's 6 x 6 board, seen at about 30 degrees, filling most of the picture.
View board_view(const std::string& name, const tagcal::Lens& lens, const tagcal::ImageSize& size,
                double distance_m) {
  View view;
  view.name = name;
  view.scene.camera = {lens, size};
  view.scene.boards = {
      {tagcal::make_board(tagcal::AprilGrid{6, 6, kTagSize, kSpacing}), tagcal::Pose()}};
  const Vector3d middle(0.33, 0.33, 0);
  const Vector3d direction(0.35, -0.36, 0.866);
  view.camera_from_world = tagcal::camera_from_world_looking_at(
      middle + distance_m * direction.normalized(), middle, Vector3d(0.2, 1, 0));
  return view;
}

tagcal::Lens brown(double scale) {
  return tagcal::Perspective(
      {900 * scale, 898 * scale, 645 * scale, 395 * scale, -0.25, 0.08, 5e-4, -3e-4, 0, 0, 0, 0});
}

// The view of the mark, and variants of it.
std::vector<View> views() {
  const tagcal::ImageSize size{1280, 800};
  std::vector<View> all;
  all.push_back(board_view("the mark: opencv5, no blur", brown(1), size, 0.75));
  all.push_back(board_view("  pinhole", tagcal::pinhole(900, 898, 645, 395), size, 0.75));
  all.push_back(board_view(
      "  fisheye", tagcal::Fisheye({420, 419, 633, 405, 0.02, -0.01, 0.003, -0.0005}), size, 0.4));
  all.push_back(board_view("  blur 0.8 px", brown(1), size, 0.75));
  all.back().scene.sensor.blur_px = 0.8;
  all.push_back(board_view("  4000 x 3000", brown(3.3), {4000, 3000}, 0.75));
  all.push_back(board_view("  no board in sight", brown(1), size, 0.75));
  all.back().scene.boards.clear();
  return all;
}

double median_ms(const std::function<void()>& work, int rounds) {
  std::vector<double> times;
  for (int i = 0; i < rounds; ++i) {
    timespec begin, end;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &begin);
    work();
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
    times.push_back(1e3 * static_cast<double>(end.tv_sec - begin.tv_sec) +
                    1e-6 * static_cast<double>(end.tv_nsec - begin.tv_nsec));
  }
  std::nth_element(times.begin(), times.begin() + rounds / 2, times.end());
  return times[static_cast<std::size_t>(rounds / 2)];
}

// Levels of single rays, computed without the renderer.
class Rays {
 public:
  explicit Rays(const View& view)
      : view_(view),
        world_from_camera_(view.camera_from_world.inverse()),
        family_(tagcal::tag_family("tag36h11", 2)) {
    for (std::size_t bit = 0; bit < family_.bits.size(); ++bit)
      bit_at_[index(family_.bits[bit].x, family_.bits[bit].y)] = static_cast<int>(bit);
  }

  double level(double u, double v) const {
    const auto ray = tagcal::ray_in_camera(view_.scene.camera.lens, {u, v});
    if (!ray) return view_.scene.background_level;
    const Vector3d from = world_from_camera_ * ray->origin;
    const Vector3d along = world_from_camera_.rotation() * ray->direction;
    const double distance = -from.z() / along.z();
    if (!(distance > 0)) return view_.scene.background_level;
    return level_on_board((from + distance * along).head<2>());
  }

  double mean(int x, int y, int samples) const {
    double sum = 0;
    for (int i = 0; i < samples; ++i)
      for (int j = 0; j < samples; ++j)
        sum += level(x - 0.5 + (j + 0.5) / samples, y - 0.5 + (i + 0.5) / samples);
    return sum / (samples * samples);
  }

 private:
  static constexpr double kGap = kSpacing * kTagSize;
  static constexpr double kPitch = kTagSize + kGap;

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y * family_.width_at_border + x);
  }

  // x, y in the board frame, whose origin is the lower left corner of tag 0.
  double level_on_board(const Vector2d& at) const {
    const tagcal::Scene& scene = view_.scene;
    const double extent = 6 * kPitch, margin = scene.paper_margin_m;
    if (at.minCoeff() < -kGap - margin || at.maxCoeff() > extent + margin)
      return scene.background_level;
    if (at.minCoeff() < -kGap || at.maxCoeff() > extent) return scene.paper_level;
    const Vector2d period(std::floor(at.x() / kPitch), std::floor(at.y() / kPitch));
    const Vector2d within = at - kPitch * period;
    const bool gap_x = within.x() > kTagSize, gap_y = within.y() > kTagSize;
    const bool black =
        gap_x || gap_y
            ? gap_x && gap_y
            : black_in_tag(static_cast<int>(period.y()) * 6 + static_cast<int>(period.x()), within);
    return black ? scene.ink_level : scene.paper_level;
  }

  bool black_in_tag(int id, const Vector2d& within) const {
    const double cell = kTagSize / family_.width_at_border;
    const int last = family_.width_at_border - 1;
    const int x = std::min(static_cast<int>(within.x() / cell), last);
    const int y = last - std::min(static_cast<int>(within.y() / cell), last);
    const auto bit = static_cast<std::size_t>(bit_at_[index(x, y)]);
    if (bit_at_[index(x, y)] < 0) return true;  // the border
    return (family_.codes[static_cast<std::size_t>(id)] >> (family_.bits.size() - 1 - bit) & 1) ==
           0;
  }

  const View& view_;
  tagcal::Pose world_from_camera_;
  tagcal::TagFamily family_;
  std::vector<int> bit_at_ = std::vector<int>(100, -1);
};

struct Errors {
  double largest = 0;
  double squares = 0;
  int count = 0;
  void add(double error) {
    largest = std::max(largest, std::abs(error));
    squares += error * error;
    ++count;
  }
  void print(const char* name) const {
    std::printf("  %-44s %8.4f %9.5f  (%d pixels)\n", name, 255 * largest,
                255 * std::sqrt(squares / count), count);
  }
};

void quality(const View& view, int samples) {
  const tagcal::ImageF light = tagcal::render_light(view.scene, families(), view.camera_from_world);
  const Rays rays(view);
  Errors flat, ours, sixteen;
  for (int y = 0; y < light.height(); ++y) {
    for (int x = 0; x < light.width(); ++x) {
      const double level = static_cast<double>(light(x, y));
      const std::array<double, 5> seen = {
          rays.level(x, y), rays.level(x - 0.5, y - 0.5), rays.level(x + 0.5, y - 0.5),
          rays.level(x - 0.5, y + 0.5), rays.level(x + 0.5, y + 0.5)};
      const bool one = std::ranges::all_of(seen, [&](double s) { return s == seen[0]; });
      if (one && std::abs(level - seen[0]) < 1e-5) {
        flat.add(level - seen[0]);
        continue;
      }
      if ((3 * x + 5 * y) % kOneOf != 0) continue;
      const double reference = rays.mean(x, y, samples);
      ours.add(level - reference);
      sixteen.add(rays.mean(x, y, 16) - reference);
    }
  }
  std::printf("%s: levels of 255 against %d x %d rays a pixel: largest error, rms\n",
              view.name.c_str(), samples, samples);
  ours.print("edge pixels, render_light");
  sixteen.print("edge pixels, 16 x 16 rays");
  flat.print("pixels without an edge, render_light");
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 31;
  const int samples = argc > 2 ? std::atoi(argv[2]) : 64;
  if (rounds < 1 || samples < 1) {
    std::fprintf(stderr, "usage: render_benchmark [rounds] [samples]\n");
    return 2;
  }
  const tagcal::TagFamilies known = families();
  const std::vector<View> all = views();
  std::printf("ms of one core, medians of %d\n", rounds);
  for (const View& view : all)
    std::printf("  %-34s %8.2f\n", view.name.c_str(),
                median_ms([&] { tagcal::render_light(view.scene, known, view.camera_from_world); },
                          rounds));
  const tagcal::ImageF light = tagcal::render_light(all[0].scene, known, all[0].camera_from_world);
  tagcal::Sensor sensor;
  std::printf("  %-34s %8.2f\n", "expose, no noise",
              median_ms([&] { tagcal::expose(light, sensor, 7); }, rounds));
  sensor.noise_levels = 2;
  std::printf("  %-34s %8.2f\n", "expose, noise",
              median_ms([&] { tagcal::expose(light, sensor, 7); }, rounds));
  const tagcal::Image8 image = tagcal::expose(light, sensor, 7);
  const auto file = std::filesystem::temp_directory_path() / "render_benchmark.png";
  const double png_ms = median_ms([&] { tagcal::write_png(file, image); }, rounds);
  std::printf("  %-34s %8.2f  (%zu kB)\n", "write_png, noise", png_ms,
              static_cast<std::size_t>(std::filesystem::file_size(file) / 1000));
  std::filesystem::remove(file);
  quality(all[0], samples);
  quality(all[2], samples);
  return 0;
}
