#include "tagcal/scene/render.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/scene/light/processing.hpp"
#include "tagcal/scene/light/shading.hpp"
#include "tagcal/scene/raster/blur.hpp"
#include "tagcal/scene/raster/depth.hpp"
#include "tagcal/scene/raster/depth_of_field.hpp"
#include "tagcal/scene/raster/noise.hpp"
#include "tagcal/scene/raster/painter.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal {
using namespace internal;
namespace {

// The lines of a rolling shutter, each from its own pose; `draw(scene, pose)` draws a picture, of
// which a line needs the `margin` lines beside it.
template <typename Draw>
ImageF by_lines(const Scene& scene, const Pose& camera_from_world, int margin, Draw&& draw) {
  if (!scene.is_rolling()) return draw(scene, camera_from_world);
  const RollingShutter& shutter = scene.sensor.shutter;
  const ImageSize& size = scene.camera.image_size;
  const int lines = shutter.by_rows() ? size.height : size.width;
  ImageF image(size);
  Scene strip = scene;
  for (int line = 0; line < lines; ++line) {
    const int first = std::max(0, line - margin), end = std::min(lines, line + margin + 1);
    const PixelRectangle part = shutter.by_rows()
                                    ? PixelRectangle{0, first, {size.width, end - first}}
                                    : PixelRectangle{first, 0, {end - first, size.height}};
    strip.camera = cropped(scene.camera, part);
    const double seconds =
        shutter.seconds_at(Eigen::Vector2d::Constant(static_cast<double>(line)), size);
    const ImageF drawn = draw(strip, moved_for(seconds, scene.velocity, camera_from_world));
    if (shutter.by_rows())
      std::copy_n(drawn.row(line - first), size.width, image.row(line));
    else
      for (int y = 0; y < size.height; ++y) image(line, y) = drawn(line - first, y);
  }
  return image;
}

ImageF render_sharp(const Scene& scene, const TagFamilies& families,
                    const Pose& camera_from_world) {
  const Camera& camera = scene.camera;
  const int scale = raster_scale(scene.sensor.blur_px);
  const Painter painter(scene, families, camera_from_world, scale);
  std::vector<Layer> layers;
  for (std::size_t i = 0; i < painter.shadows().sheets().size(); ++i)
    layers.push_back(painter.layer_of(i));
  const Canvas canvas(layers, static_cast<float>(scene.background_level),
                      {camera.lens, {0, 0}, camera.image_size, scale});
  return canvas.sampled(scene.sensor.blur_px, static_cast<float>(scene.sensor.exposure));
}

void check_focus(const Camera& camera, const Sensor& sensor) {
  if (sensor.focus && sensor.shutter.readout_s > 0)
    throw Error("focus: does not go with a rolling shutter (readout_ms)");
  if (sensor.focus && &kind_of(camera.lens) != &kind_of<Perspective>())
    throw Error("focus: needs a perspective lens, not a " + std::string(kind_of(camera.lens).name) +
                " one");
}

struct Rows {
  int first = 0, count = 0;
};

// The values of the pixels of some rows, with noise and before processing. With a mosaic the
// gamma comes later.
Levels noisy_rows(const ImageF& light, const Sensor& sensor, double white, std::uint64_t seed,
                  const Rows& rows) {
  const double noise = sensor.noise_levels * (white / 255);
  const double gamma = sensor.mosaic ? 1 : sensor.gamma;
  Levels levels({light.width(), rows.count});
  for (int row = 0; row < rows.count; ++row) {
    const int y = rows.first + row;
    NormalNoise standard({seed, static_cast<std::uint64_t>(y)});
    for (int x = 0; x < light.width(); ++x) {
      double level = white * encoded(static_cast<double>(light(x, y)), gamma);
      if (sensor.mosaic) level *= filter_gain(*sensor.mosaic, x, y);
      if (noise > 0) level += noise * standard.next();
      levels(x, row) = clipped(level, white);
    }
  }
  return levels;
}

template <typename Level>
Image<Level> exposed(const ImageF& light, const Sensor& sensor, std::uint64_t seed) {
  constexpr double kWhite = std::numeric_limits<Level>::max();
  check_processing(sensor);
  Image<Level> image(light.size());
  const int at_once = is_processed(sensor) ? light.height() : 1;
  for (int y = 0; y < light.height(); y += at_once) {
    Levels levels = noisy_rows(light, sensor, kWhite, seed, {y, at_once});
    process(sensor, kWhite, levels);
    std::transform(levels.pixels().begin(), levels.pixels().end(), image.row(y), [](double level) {
      return static_cast<Level>(clipped(level, kWhite) + 0.5);  // rounds half up
    });
  }
  return image;
}

}  // namespace

ImageF render_light(const Scene& scene, const TagFamilies& families,
                    const Pose& camera_from_world) {
  if (scene.ink_spread_m > scene.paper_margin_m)
    throw Error("scene: ink_spread_m: must not be above paper_margin_m, got " +
                short_number(scene.ink_spread_m));
  check_focus(scene.camera, scene.sensor);
  const int margin = blur_reach_px(scene.sensor.blur_px);
  ImageF light = scene.sensor.focus ? render_in_focus(scene, families, camera_from_world)
                                    : by_lines(scene, camera_from_world, margin,
                                               [&](const Scene& strip, const Pose& pose) {
                                                 return render_sharp(strip, families, pose);
                                               });
  vignette(scene.camera, scene.sensor.vignetting, light);
  return light;
}

void check_sensor(const Camera& camera, const Sensor& sensor) {
  check_focus(camera, sensor);
  check_vignetting(camera, sensor.vignetting);
  check_processing(sensor);
}

ImageF render_depth(const Scene& scene, const Pose& camera_from_world) {
  return by_lines(scene, camera_from_world, 0, [](const Scene& strip, const Pose& pose) {
    const Shadows shadows(strip, strip.camera.lens, pose);
    return depth_of_sheets(shadows, shadows.all(), strip.camera);
  });
}

Image16 depth_levels(const ImageF& depth, double unit_m, std::size_t* num_beyond) {
  constexpr double kMost = std::numeric_limits<std::uint16_t>::max();
  Image16 levels(depth.size());
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) {
      if (std::isnan(depth(x, y))) continue;
      const double units = std::round(static_cast<double>(depth(x, y)) / unit_m);
      if (units >= 1 && units <= kMost)
        levels(x, y) = static_cast<std::uint16_t>(units);
      else if (num_beyond)
        ++*num_beyond;
    }
  return levels;
}

Image8 expose(const ImageF& light, const Sensor& sensor, std::uint64_t seed) {
  return exposed<std::uint8_t>(light, sensor, seed);
}

Image16 expose16(const ImageF& light, const Sensor& sensor, std::uint64_t seed) {
  Sensor of_16_bits = sensor;
  of_16_bits.bits = 16;
  return exposed<std::uint16_t>(light, of_16_bits, seed);
}

}  // namespace tagcal
