#include "draw.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "defects.hpp"

namespace tagcal {
namespace {

// Another gamma with the same levels in the picture.
void set_gamma(double gamma, Scene& scene) {
  const double power = scene.sensor.gamma / gamma;
  for (double* level : {&scene.background_level, &scene.paper_level, &scene.ink_level})
    *level = std::pow(*level, power);
  scene.sensor.gamma = gamma;
}

// White paper at 1.3 to 2 times the level that the sensor can tell.
void clip(Scene& scene, Random& random) {
  scene.sensor.exposure = random.uniform(1.3, 2) / scene.paper_level;
}

// Filters as those of a camera in daylight. Its noise is of the linear light.
void add_mosaic(Scene& scene, Random& random) {
  constexpr const char* kPatterns[] = {"RGGB", "BGGR", "GRBG", "GBRG"};
  Mosaic mosaic{kPatterns[random.index(std::size(kPatterns))]};
  mosaic.gains[0] = random.uniform(0.4, 0.7);
  mosaic.gains[2] = random.uniform(0.5, 0.8);
  scene.sensor.mosaic = mosaic;
  set_gamma(1, scene);
}

void add_raw_mosaic(Scene& scene, Random& random) {
  add_mosaic(scene, random);
  scene.sensor.mosaic->demosaic = false;
}

void denoise(Scene& scene, Random& random) {
  const double levels = scene.sensor.noise_levels * random.uniform(1, 3);
  scene.sensor.denoise = Denoise{levels, random.uniform(0.7, 1.5)};
}

void sharpen(Scene& scene, Random& random) {
  const double amount = random.uniform(0.3, 1.5);
  scene.sensor.sharpen = Sharpen{amount, random.uniform(0.7, 2)};
}

void compress(Scene& scene, Random& random) {
  scene.sensor.jpeg = 40 + static_cast<int>(random.index(51));
}

void use_webcam(Scene& scene, Random& random) {
  set_gamma(random.uniform(0.45, 0.6), scene);
  sharpen(scene, random);
  compress(scene, random);
}

void use_phone(Scene& scene, Random& random) {
  denoise(scene, random);
  use_webcam(scene, random);
}

void add_vignetting(Scene& scene, Random& random) {
  scene.sensor.vignetting.polynomial = {-random.uniform(0.3, 0.7)};
}

// Sharp at the distance of the board's centre in the median view. At 1.2 times that distance the
// blur has a standard deviation of 0.2 to 1.5 px. The aperture is a multiple of 2^-20 m, so that a
// scene file in millimetres has exactly this number.
void defocus(Scene& scene, Random& random) {
  constexpr double kFarther = 1.2, kUnit_m = 0x1p-20;
  const std::vector<TargetPoint> points = target_points(scene.boards[0].board);
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const TargetPoint& point : points)
    centre += point.position / static_cast<double>(points.size());
  std::vector<double> depths;
  for (const Pose& pose : std::get<ExplicitPath>(scene.path).camera_from_world)
    depths.push_back((pose * centre).z());
  const auto median = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), median, depths.end());
  const double blur_px = log_uniform(0.2, 1.5, random), f_px = parameters(scene.camera.lens)[0];
  const double aperture_m = 4 * blur_px * *median / (f_px * (1 - 1 / kFarther));  // as Focus says
  scene.sensor.focus = Focus{*median, kUnit_m * std::ceil(aperture_m / kUnit_m)};
}

// A drawing with 6 to 13 pixels a cell, never a whole number of them.
void round_print(Scene& scene, Random& random) {
  const auto& grid = std::get<AprilGrid>(scene.boards[0].board.pattern);
  const std::size_t cells = 6 + 2 * static_cast<std::size_t>(grid.border_bits);  // of tag36h11
  const std::size_t pixels = cells * (6 + random.index(7)) + 1 + random.index(cells - 1);
  scene.print_grid_m = grid.tag_size / static_cast<double>(pixels);
}

struct PictureKind {
  const char* name;
  void (*change)(Scene& scene, Random& random);
};
constexpr PictureKind kKinds[] = {
    {"clipped", clip},      {"mosaic", add_mosaic},  {"raw", add_raw_mosaic},
    {"denoised", denoise},  {"sharpened", sharpen},  {"jpeg", compress},
    {"webcam", use_webcam}, {"phone", use_phone},    {"vignetting", add_vignetting},
    {"defocus", defocus},   {"rounded", round_print}};

bool suits(const PictureKind& kind, const Lens& lens) {
  return kind.change != defocus || &kind_of(lens) == &kind_of<Perspective>();
}

}  // namespace

std::vector<std::string> picture_kinds() {
  std::vector<std::string> names;
  for (const PictureKind& kind : kKinds) names.emplace_back(kind.name);
  return names;
}

std::string draw_pictures(const std::string& kind, Scene& scene, Random& random) {
  std::vector<PictureKind> kinds;
  for (const PictureKind& k : kKinds)
    if (suits(k, scene.camera.lens) && (kind.empty() || kind == k.name)) kinds.push_back(k);
  if (kinds.empty()) return "";
  const PictureKind& drawn = kinds[random.index(kinds.size())];
  drawn.change(scene, random);
  return drawn.name;
}

}  // namespace tagcal
