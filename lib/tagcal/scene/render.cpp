#include "tagcal/scene/render.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "tagcal/error.hpp"
#include "tagcal/scene/raster/blur.hpp"
#include "tagcal/scene/raster/coverage.hpp"
#include "tagcal/scene/raster/noise.hpp"
#include "tagcal/scene/raster/tracer.hpp"
#include "tagcal/scene/visibility/sheets.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector3d;

constexpr int kBandRows = 16;  // of the raster, painted at once: they fit the processor's cache

// A surface that is painted over those behind it: paper, then ink on the paper.
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

// Makes the layers of one view.
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
    for (const Rectangle& cell : ink_cells(placed.board, *sheet.panel,
                                           family_of(placed.board, families), scene.ink_spread_m)) {
      const std::vector<Vector3d> corners = moved(camera_from_board, cell);
      if (whole)
        tracer.trace_whole(corners, ink);
      else
        tracer.trace(corners, ink);
    }
  }
};

// Paints layers over each other, one band of the raster after the other.
class Canvas {
 public:
  Canvas(const std::vector<Layer>& layers, float background, const ImageSize& size)
      : background_(background), size_(size) {
    for (const Layer& layer : layers)
      layers_.push_back({by_band(layer.paper), by_band(layer.ink), layer.paper_level,
                         layer.ink_level - layer.paper_level});
  }

  // Calls use(row, levels, passed) for every row of the raster, from the top; the level changes
  // only in blocks of cells in `passed`.
  template <typename Use>
  void paint(Use&& use) const {
    ImageF light({size_.width, kBandRows});
    CoverageBand coverage(size_.width, kBandRows);
    for (int band = 0; band * kBandRows < size_.height; ++band) {
      coverage.move_to(band * kBandRows);
      std::fill_n(light.row(0), light.pixels().size(), background_);
      for (const BandedLayer& layer : layers_) add(layer, band, coverage, light);
      const int rows = std::min(kBandRows, size_.height - band * kBandRows);
      for (int r = 0; r < rows; ++r) use(band * kBandRows + r, light.row(r), coverage.passed(r));
    }
  }

 private:
  // The edges in each band.
  using Bands = std::vector<std::vector<Outlines::Edge>>;

  struct BandedLayer {
    Bands paper;
    Bands ink;
    float paper_level;
    float ink_step;  // ink level minus paper level
  };

  Bands by_band(const Outlines& outlines) const {
    const int count = (size_.height + kBandRows - 1) / kBandRows;
    Bands bands(static_cast<std::size_t>(count));
    const auto band_at = [&](double y) {
      return static_cast<int>(std::clamp(y / kBandRows, 0.0, count - 1.0));
    };
    for (const Outlines::Edge& edge : outlines.edges()) {
      const auto [top, bottom] = std::minmax(edge.from.y(), edge.to.y());
      if (bottom <= 0 || top >= size_.height) continue;
      for (int band = band_at(top); band <= band_at(bottom); ++band)
        bands[static_cast<std::size_t>(band)].push_back(edge);
    }
    return bands;
  }

  static void add(const BandedLayer& layer, int band, CoverageBand& coverage, ImageF& light) {
    coverage.accumulate(layer.paper[static_cast<std::size_t>(band)]);
    coverage.drain([&](int r, int first, int last, float share) {
      float* levels = light.row(r);
      for (int c = first; c < last; ++c) levels[c] += share * (layer.paper_level - levels[c]);
    });
    coverage.accumulate(layer.ink[static_cast<std::size_t>(band)]);
    coverage.drain([&](int r, int first, int last, float share) {
      float* levels = light.row(r);
      const float step = share * layer.ink_step;
      for (int c = first; c < last; ++c) levels[c] += step;
    });
  }

  float background_;
  ImageSize size_;
  std::vector<BandedLayer> layers_;
};

// Number of raster cells per pixel: 1 without blur, because areas are exact; with blur the Gaussian
// must be wide compared with the cells.
int raster_scale(double blur_px) {
  if (blur_px <= 0) return 1;
  return std::clamp(static_cast<int>(std::ceil(1 / blur_px)), 4, 16);
}

double encoded(float light, double gamma) {
  const auto linear = static_cast<double>(light);
  return gamma == 1 ? linear : std::pow(std::max(0.0, linear), gamma);
}

template <typename Level>
Image<Level> exposed(const ImageF& light, const Sensor& sensor, std::uint64_t seed) {
  constexpr double kWhite = std::numeric_limits<Level>::max();
  const double noise = sensor.noise_levels * (kWhite / 255), gamma = sensor.gamma;
  Image<Level> image(light.size());
  for (int y = 0; y < light.height(); ++y) {
    NormalNoise standard({seed, static_cast<std::uint64_t>(y)});
    std::transform(light.row(y), light.row(y) + light.width(), image.row(y), [&](float linear) {
      double level = kWhite * encoded(linear, gamma);
      if (noise > 0) level += noise * standard.next();
      return static_cast<Level>(std::max(0.0, std::min(level, kWhite)) + 0.5);  // rounds half up
    });
  }
  return image;
}

}  // namespace

ImageF render_light(const Scene& scene, const TagFamilies& families,
                    const Pose& camera_from_world) {
  if (scene.ink_spread_m > scene.paper_margin_m)
    throw Error("scene: ink_spread_m: must not be above paper_margin_m, got " +
                std::to_string(scene.ink_spread_m));
  const ImageSize& size = scene.camera.image_size;
  const double blur = scene.sensor.blur_px;
  const int scale = raster_scale(blur);
  const Painter painter{scene, families, camera_from_world, {scene.camera.lens, scale * 1.0}};
  const Eye at = eye(scene.camera.lens, camera_from_world);
  const std::vector<Sheet> all = sheets(scene);
  std::vector<Layer> layers;
  for (const std::size_t i : painting_order(all, at))
    layers.push_back(painter.layer_of(all[i], faces(all[i], at)));

  const Canvas canvas(layers, static_cast<float>(scene.background_level),
                      {size.width * scale, size.height * scale});
  const auto exposure = static_cast<float>(scene.sensor.exposure);
  ImageF light(size);
  if (blur <= 0) {
    canvas.paint([&](int y, const float* levels, auto) {
      std::transform(levels, levels + size.width, light.row(y),
                     [exposure](float level) { return exposure * level; });
    });
    return light;
  }
  Blur filter(blur, scale, exposure, light);
  canvas.paint([&](int, const float* levels, auto passed) { filter.add_row(levels, passed); });
  filter.finish();
  return light;
}

Image8 expose(const ImageF& light, const Sensor& sensor, std::uint64_t seed) {
  return exposed<std::uint8_t>(light, sensor, seed);
}

Image16 expose16(const ImageF& light, const Sensor& sensor, std::uint64_t seed) {
  return exposed<std::uint16_t>(light, sensor, seed);
}

}  // namespace tagcal
