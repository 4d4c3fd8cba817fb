#include <array>
#include <cmath>

#include "draw.hpp"
#include "tagcal/camera/model.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/uncertainty/seen_region.hpp"

namespace tagcal {
namespace {

constexpr std::array<const char*, 9> kModels = {
    "f", "f+c", "pinhole", "radial1", "radial2", "opencv4", "opencv5", "opencv8", "fisheye4"};
constexpr double kWidestPerspectiveDeg = 115;
constexpr double kWidestFisheyeDeg = 185;

ImageSize draw_size(Random& random) {
  constexpr ImageSize kSizes[] = {{320, 240}, {320, 240}, {320, 240}, {384, 384},
                                  {480, 360}, {480, 360}, {512, 384}, {640, 400},
                                  {640, 480}, {640, 480}, {512, 512}, {1024, 768}};
  return kSizes[random.index(std::size(kSizes))];
}

// Draws the parameters of the models beside the focal length. `s` is the square of the radius of
// the image's corner in units of the focal length. Terms are drawn by their displacement of the
// corner of the image, as a share of its radius.
struct LensDraw {
  double f, cx, cy, s;
  Random& random;

  double term(double low, double high, int power, double share_negative = 0.5) {
    return signed_log_uniform(low, high, share_negative, random) / std::pow(s, power);
  }
  double fy() { return f * (1 + signed_log_uniform(3e-4, 0.02, 0.5, random)); }

  Lens rational() {
    const double b1 = random.uniform(0, 1), b2 = random.uniform(0, 0.3),
                 b3 = random.uniform(0, 0.05);
    const double s2 = s * s, s3 = s2 * s;
    const double p = 0.5 * std::sqrt(s);
    return Perspective({f, fy(), cx, cy, b1 / s + term(0.01, 0.3, 1, 0.8),
                        b2 / s2 + term(0.003, 0.1, 2), p * term(1e-4, 0.005, 1),
                        p * term(1e-4, 0.005, 1), b3 / s3 + term(0.001, 0.03, 3), b1 / s, b2 / s2,
                        b3 / s3});
  }

  Lens of(const std::string& model) {
    if (model == "f" || model == "f+c") return pinhole(f, f, cx, cy);
    if (model == "pinhole") return pinhole(f, fy(), cx, cy);
    if (model == "opencv8") return rational();
    if (model == "fisheye4")
      return Fisheye({f, fy(), cx, cy, term(0.003, 0.15, 1), term(0.002, 0.08, 2),
                      term(0.001, 0.04, 3), term(0.001, 0.02, 4)});
    const double k1 = term(0.002, 0.35, 1, 0.75);
    if (model == "radial1") return Perspective({f, f, cx, cy, k1});
    const double k2 = term(0.001, 0.15, 2);
    if (model == "radial2") return Perspective({f, f, cx, cy, k1, k2});
    const double p = 0.5 * std::sqrt(s);
    const double k3 = model == "opencv4" ? 0 : term(0.001, 0.05, 3);
    return Perspective(
        {f, fy(), cx, cy, k1, k2, p * term(1e-4, 0.01, 1), p * term(1e-4, 0.01, 1), k3});
  }
};

Lens draw_lens(const std::string& model, const ImageSize& size, Random& random) {
  const bool fisheye = model == "fisheye4";
  const double angle =
      internal::kDegree * (fisheye ? random.uniform(50, 180) : random.uniform(30, 110));
  const double f = fisheye ? size.width / angle : focal_from_field_of_view_px(angle, size.width);
  Eigen::Vector2d c = image_centre(size);
  if (model != "f") {
    const double away = size.width * log_uniform(0.001, 0.02, random);
    const double dx = away * random.normal();
    c += Eigen::Vector2d(dx, away * random.normal());
  }
  const double corner = std::hypot(size.width, size.height) / 2 / f;
  return LensDraw{f, c.x(), c.y(), corner * corner, random}.of(model);
}

// True if the lens has no fold and no pole inside the image.
bool sees_whole_image(const Camera& camera) {
  for (const Eigen::Vector2d& pixel : ImageGrid{camera.image_size, 33, 25}.pixels()) {
    const auto ray = ray_in_camera(camera.lens, pixel);
    if (!ray || !in_domain(camera.lens, ray->direction)) return false;
  }
  return true;
}

}  // namespace

DrawnCamera draw_camera(Random& random) {
  const std::string model = kModels[random.index(kModels.size())];
  const double widest = model == "fisheye4" ? kWidestFisheyeDeg : kWidestPerspectiveDeg;
  while (true) {
    const ImageSize size = draw_size(random);
    const Camera camera{draw_lens(model, size, random), size};
    if (!sees_whole_image(camera)) continue;
    const auto view = field_of_view(camera);
    if (!view) continue;
    const double degrees = internal::degrees(1) * view->horizontal_rad;
    if (degrees < widest) return {camera, model, degrees};
  }
}

}  // namespace tagcal
