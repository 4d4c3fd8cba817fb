#include "tagcal/scene/render.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "tagcal/error.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/coverage.hpp"
#include "tagcal/scene/sheets.hpp"
#include "tagcal/scene/tracer.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;

constexpr int kBandRows = 16;    // of the output, worked on at once

// Something painted over what is behind it: `fill` where `over` covers, then `ink` on it.
struct Layer {
  Outlines paper;
  Outlines ink;
  float paper_level = 0;
  float ink_level = 0;
};

const TagFamily& family_of(const Board& board, const TagFamilies& families) {
  const auto family = families.find(board.family);
  if (family == families.end()) throw Error("render: family " + board.family + " is not known");
  return family->second;
}

std::vector<Vector3d> moved(const Pose& target_from_source, std::span<const Vector3d> corners) {
  std::vector<Vector3d> result;
  for (const Vector3d& corner : corners) result.push_back(target_from_source * corner);
  return result;
}

// A view's camera, and what is needed to know the print on a board.
struct Painter {
  const Scene& scene;
  const TagFamilies& families;
  const Pose& camera_from_world;
  Tracer tracer;

  Layer layer_of(const Sheet& sheet, bool front) const {
    Layer layer;
    const std::vector<Vector3d> outline = moved(camera_from_world, sheet.corners);
    tracer.trace(outline, layer.paper);
    if (!sheet.panel) {
      layer.paper_level = static_cast<float>(scene.occluders[sheet.occluder].level);
      return layer;
    }
    layer.paper_level = static_cast<float>(scene.paper_level);
    layer.ink_level = static_cast<float>(scene.ink_level);
    if (front) print(sheet, tracer.sees_whole(outline), layer.ink);
    return layer;
  }

  void print(const Sheet& sheet, bool whole, Outlines& ink) const {
    const PlacedBoard& placed = scene.boards[sheet.board];
    const Pose camera_from_board = camera_from_world * placed.world_from_board;
    for (const Rectangle& cell :
         ink_cells(placed.board, *sheet.panel, family_of(placed.board, families))) {
      const std::vector<Vector3d> corners = moved(camera_from_board, cell);
      if (whole)
        tracer.trace_whole(corners, ink);
      else
        tracer.trace(corners, ink);
    }
  }
};

// Light in the rows [first, first + rows) of the raster.
ImageF paint_band(const std::vector<Layer>& layers, float background, int width, int first,
                  int rows) {
  ImageF light({width, rows}, background);
  CoverageBand band(width, first, rows);
  for (const Layer& layer : layers) {
    band.accumulate(layer.paper);
    band.drain([&](int r, int c, float share) {
      float& value = light(c, r);
      value += share * (layer.paper_level - value);
    });
    band.accumulate(layer.ink);
    const float step = layer.ink_level - layer.paper_level;
    band.drain([&](int r, int c, float share) { light(c, r) += share * step; });
  }
  return light;
}

// Weights by which the `scale` finer cells about a pixel make its value: the pixel's box is a sum
// of `scale` cells' boxes, the Gaussian is sampled (its spectrum ends far below the cells'
// frequency).
struct Taps {
  int first = 0;  // relative to the pixel's first cell
  std::vector<float> weights;
};

Taps taps(double blur_px, int scale) {
  if (blur_px <= 0)
    return {0,
            std::vector<float>(static_cast<std::size_t>(scale), 1.0f / static_cast<float>(scale))};
  const double sigma = blur_px * scale;
  const int reach = static_cast<int>(std::ceil(5 * sigma));
  std::vector<double> weights(static_cast<std::size_t>(2 * reach + scale), 0.0);
  double sum = 0;
  for (int i = -reach; i <= reach; ++i) {
    const double g = std::exp(-0.5 * i * i / (sigma * sigma));
    for (int j = 0; j < scale; ++j) weights[static_cast<std::size_t>(i + reach + j)] += g;
    sum += scale * g;
  }
  Taps result{-reach, {}};
  for (const double w : weights) result.weights.push_back(static_cast<float>(w / sum));
  return result;
}

// One row of finer cells to pixels; cells beyond the border repeat the last one.
void filter_row(const float* cells, int num_cells, const Taps& t, int scale,
                std::vector<float>& padded, float* pixels, int num_pixels) {
  const int before = -t.first;
  const int after = static_cast<int>(t.weights.size());
  padded.resize(static_cast<std::size_t>(before + num_cells + after));
  std::fill_n(padded.begin(), before, cells[0]);
  std::copy_n(cells, num_cells, padded.begin() + before);
  std::fill_n(padded.begin() + before + num_cells, after, cells[num_cells - 1]);
  for (int x = 0; x < num_pixels; ++x) {
    const float* from =
        padded.data() + static_cast<std::size_t>(x) * static_cast<std::size_t>(scale);
    float sum = 0;
    for (std::size_t i = 0; i < t.weights.size(); ++i) sum += t.weights[i] * from[i];
    pixels[x] = sum;
  }
}

ImageF filter_columns(const ImageF& rows, const Taps& t, int scale, int height) {
  ImageF result({rows.width(), height}, 0.0f);
  for (int y = 0; y < height; ++y) {
    float* out = result.row(y);
    for (std::size_t i = 0; i < t.weights.size(); ++i) {
      const int r = std::clamp(y * scale + t.first + static_cast<int>(i), 0, rows.height() - 1);
      const float* in = rows.row(r);
      for (int x = 0; x < rows.width(); ++x) out[x] += t.weights[i] * in[x];
    }
  }
  return result;
}

// How much finer than the image the raster is: exact areas need no more without blur; with it, the
// Gaussian must be wide against the cells.
int raster_scale(double blur_px) {
  if (blur_px <= 0) return 1;
  return std::clamp(static_cast<int>(std::ceil(1 / blur_px)), 4, 16);
}

template <typename Level>
Image<Level> exposed(const ImageF& light, const Sensor& sensor, std::uint64_t seed) {
  constexpr double kWhite = std::numeric_limits<Level>::max();
  const double noise = sensor.noise_levels * (kWhite / 255);
  Image<Level> image(light.size());
  for (int y = 0; y < light.height(); ++y) {
    Random random(seed, static_cast<std::uint64_t>(y));
    for (int x = 0; x < light.width(); ++x) {
      double level = kWhite * static_cast<double>(light(x, y));
      if (noise > 0) level += noise * random.normal();
      image(x, y) = static_cast<Level>(std::lround(std::clamp(level, 0.0, kWhite)));
    }
  }
  return image;
}

}  // namespace

ImageF render_light(const Scene& scene, const TagFamilies& families,
                    const Pose& camera_from_world) {
  const ImageSize& size = scene.camera.image_size;
  const double blur = scene.sensor.blur_px;
  const int scale = raster_scale(blur);
  const Painter painter{scene, families, camera_from_world, {scene.camera.lens, scale * 1.0}};
  const Eye at = eye(scene.camera.lens, camera_from_world);
  const std::vector<Sheet> all = sheets(scene);
  std::vector<Layer> layers;
  for (const std::size_t i : painting_order(all, at))
    layers.push_back(painter.layer_of(all[i], faces(all[i], at)));

  const Taps t = taps(blur, scale);
  ImageF rows({size.width, size.height * scale}, 0.0f);
  std::vector<float> padded;
  for (int first = 0; first < rows.height(); first += kBandRows * scale) {
    const int count = std::min(kBandRows * scale, rows.height() - first);
    const ImageF light = paint_band(layers, static_cast<float>(scene.background_level),
                                    size.width * scale, first, count);
    for (int r = 0; r < count; ++r)
      filter_row(light.row(r), light.width(), t, scale, padded, rows.row(first + r), size.width);
  }
  ImageF result = filter_columns(rows, t, scale, size.height);
  const auto exposure = static_cast<float>(scene.sensor.exposure);
  for (int y = 0; y < size.height; ++y)
    std::transform(result.row(y), result.row(y) + size.width, result.row(y),
                   [exposure](float value) { return value * exposure; });
  return result;
}

Image8 expose(const ImageF& light, const Sensor& sensor, std::uint64_t seed) {
  return exposed<std::uint8_t>(light, sensor, seed);
}

Image16 expose16(const ImageF& light, const Sensor& sensor, std::uint64_t seed) {
  return exposed<std::uint16_t>(light, sensor, seed);
}

}  // namespace tagcal
