#include "tagcal/scene/render.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/camera/clip.hpp"
#include "tagcal/error.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/coverage.hpp"
#include "tagcal/scene/sheets.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kChordErrorPx = 1e-4;
constexpr int kDeepestCut = 12;  // an edge is cut into at most 2^12 pieces
constexpr int kBandRows = 16;    // of the output, worked on at once

// Something painted over what is behind it: `fill` where `over` covers, then `ink` on it.
struct Layer {
  Outlines paper;
  Outlines ink;
  float paper_level = 0;
  float ink_level = 0;
};

// Follows the image of polygons through the lens, in cells of a raster `scale` times the image's.
class Tracer {
 public:
  Tracer(const Lens& lens, const Pose& camera_from_world, int scale)
      : lens_(lens), camera_from_world_(camera_from_world), scale_(scale) {}

  void trace(const std::vector<Vector3d>& polygon_in_world, Outlines& outlines) const {
    std::vector<Vector3d> polygon;
    for (const Vector3d& corner : polygon_in_world) polygon.push_back(camera_from_world_ * corner);
    const double size = (polygon[0] - polygon[polygon.size() / 2]).norm();
    for (const auto& part : clip_to_domain(polygon, lens_, 1e-6 * size)) {
      std::vector<Vector2d> traced;
      bool whole = true;
      for (std::size_t i = 0; i < part.size() && whole; ++i)
        whole = follow(part[i], part[(i + 1) % part.size()], kDeepestCut, traced);
      if (whole && traced.size() >= 3) outlines.add(traced);
    }
  }

 private:
  // Appends the image of a and of what lies between a and b, to the chord error.
  bool follow(const Vector3d& a, const Vector3d& b, int depth, std::vector<Vector2d>& out) const {
    const std::optional<Vector2d> pixel_a = project(lens_, a), pixel_b = project(lens_, b);
    if (!pixel_a || !pixel_b) return false;
    bool straight = true;
    for (const double share : {0.25, 0.5, 0.75}) {
      const std::optional<Vector2d> between = project(lens_, (1 - share) * a + share * b);
      if (!between) return false;
      straight &= off_chord(*pixel_a, *pixel_b, *between) < kChordErrorPx;
    }
    if (straight || depth == 0) {
      out.push_back(scale_ * (*pixel_a + Vector2d(0.5, 0.5)));
      return true;
    }
    const Vector3d middle = 0.5 * (a + b);
    return follow(a, middle, depth - 1, out) && follow(middle, b, depth - 1, out);
  }

  static double off_chord(const Vector2d& a, const Vector2d& b, const Vector2d& p) {
    const Vector2d chord = b - a, offset = p - a;
    const double length = chord.norm();
    if (length < 1e-12) return offset.norm();
    return std::abs(chord.x() * offset.y() - chord.y() * offset.x()) / length;
  }

  const Lens& lens_;
  const Pose& camera_from_world_;
  double scale_;
};

const TagFamily& family_of(const Board& board, const TagFamilies& families) {
  const auto family = families.find(board.family);
  if (family == families.end()) throw Error("render: family " + board.family + " is not known");
  return family->second;
}

Layer layer_of(const Sheet& sheet, const Scene& scene, const TagFamilies& families,
               const Tracer& tracer, bool front) {
  Layer layer;
  if (!sheet.panel) {
    tracer.trace(sheet.corners, layer.paper);
    layer.paper_level = static_cast<float>(scene.occluders[sheet.occluder].level);
    return layer;
  }
  tracer.trace(sheet.corners, layer.paper);
  layer.paper_level = static_cast<float>(scene.paper_level);
  layer.ink_level = static_cast<float>(scene.ink_level);
  if (!front) return layer;
  const PlacedBoard& placed = scene.boards[sheet.board];
  for (const Rectangle& cell :
       ink_cells(placed.board, *sheet.panel, family_of(placed.board, families))) {
    std::vector<Vector3d> corners;
    for (const Vector3d& corner : cell) corners.push_back(placed.world_from_board * corner);
    tracer.trace(corners, layer.ink);
  }
  return layer;
}

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
  const Tracer tracer(scene.camera.lens, camera_from_world, scale);
  const Eye at = eye(scene.camera.lens, camera_from_world);
  const std::vector<Sheet> all = sheets(scene);
  std::vector<Layer> layers;
  for (const std::size_t i : painting_order(all, at))
    layers.push_back(layer_of(all[i], scene, families, tracer, faces(all[i], at)));

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
