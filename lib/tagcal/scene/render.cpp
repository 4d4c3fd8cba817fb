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
#include "tagcal/scene/visibility/shadows.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector3d;
using Polygon = std::vector<Vector3d>;

constexpr int kBandRows = 16;  // of the raster, painted at once: they fit the processor's cache

// What the eye sees of a surface: paper, and ink on the paper.
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

Polygon moved(const Pose& target_from_source, std::span<const Vector3d> corners) {
  Polygon result;
  for (const Vector3d& corner : corners) result.push_back(target_from_source * corner);
  return result;
}

// Makes the layers of one view, in the camera frame.
struct Painter {
  const Scene& scene;
  const TagFamilies& families;
  const Pose& camera_from_world;
  Tracer tracer;
  Shadows shadows{scene, scene.camera.lens, camera_from_world};

  Layer layer_of(std::size_t index) const {
    const Sheet& sheet = shadows.sheets()[index];
    Layer layer;
    const std::vector<Polygon> parts = seen_parts(sheet.corners, index);
    for (const Polygon& part : parts) tracer.trace(part, layer.paper);
    if (!sheet.panel) {
      layer.paper_level = static_cast<float>(scene.occluders[sheet.occluder].level);
      return layer;
    }
    layer.paper_level = static_cast<float>(scene.paper_level);
    layer.ink_level = static_cast<float>(scene.ink_level);
    const bool whole = parts.size() == 1 && parts[0] == sheet.corners;
    if (shadows.faces(index)) print(index, whole, layer.ink);
    return layer;
  }

  std::vector<Polygon> seen_parts(const Polygon& polygon, std::size_t index) const {
    std::vector<Polygon> seen;
    for (const Polygon& part : tracer.in_domain(polygon))
      for (Polygon& visible : shadows.visible_parts(part, index))
        seen.push_back(std::move(visible));
    return seen;
  }

  // All cells are seen if the whole sheet is.
  void print(std::size_t index, bool whole, Outlines& ink) const {
    const Sheet& sheet = shadows.sheets()[index];
    const PlacedBoard& placed = scene.boards[sheet.board];
    const Pose camera_from_board = camera_from_world * placed.world_from_board;
    for (const Rectangle& cell : ink_cells(placed.board, *sheet.panel,
                                           family_of(placed.board, families), scene.ink_spread_m)) {
      const Polygon corners = moved(camera_from_board, cell);
      if (whole)
        tracer.trace(corners, ink);
      else
        for (const Polygon& part : seen_parts(corners, index)) tracer.trace(part, ink);
    }
  }
};

// Adds up layers, which cover no point twice, one band of the raster after the other.
class Canvas {
 public:
  Canvas(const std::vector<Layer>& layers, float background, const ImageSize& size)
      : background_(background), size_(size) {
    for (const Layer& layer : layers)
      layers_.push_back({by_band(layer.paper), by_band(layer.ink), layer.paper_level - background,
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
    float paper_step;  // paper level minus background
    float ink_step;    // ink level minus paper level
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
    const auto add_areas = [&](const Bands& bands, float level) {
      coverage.accumulate(bands[static_cast<std::size_t>(band)]);
      coverage.drain([&](int r, int first, int last, float share) {
        float* levels = light.row(r);
        const float step = share * level;
        for (int c = first; c < last; ++c) levels[c] += step;
      });
    };
    add_areas(layer.paper, layer.paper_step);
    add_areas(layer.ink, layer.ink_step);
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
  std::vector<Layer> layers;
  for (std::size_t i = 0; i < painter.shadows.sheets().size(); ++i)
    layers.push_back(painter.layer_of(i));

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
