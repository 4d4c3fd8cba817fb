#include "tagcal/scene/raster/canvas.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/scene/raster/blur.hpp"

namespace tagcal::internal {
namespace {

constexpr int kBandRows = 16;  // of the raster, painted at once: they fit the processor's cache

}  // namespace

int raster_scale(double blur_px) {
  if (blur_px <= 0) return 1;
  return std::clamp(static_cast<int>(std::ceil(1 / blur_px)), 4, 16);
}

Canvas::Canvas(const std::vector<Layer>& layers, float background, const Raster& raster)
    : background_(background), raster_(raster), size_(raster.cells()) {
  for (const Layer& layer : layers) {
    const bool uniform = layer.shading.is_uniform();
    const float factor = uniform ? static_cast<float>(layer.shading.uniform()) : 1;
    is_shaded_ |= !uniform;
    layers_.push_back({by_band(layer.paper), by_band(layer.ink), factor * layer.paper_level,
                       factor * layer.ink_level, layer.shading});
  }
}

Canvas::Bands Canvas::by_band(const Outlines& outlines) const {
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

Canvas::PixelRays Canvas::rays_of(int band) const {
  const int first = band * kBandRows / raster_.scale;
  const int last = (band * kBandRows + kBandRows - 1) / raster_.scale;
  PixelRays result{first, {}};
  for (int y = first; y <= last; ++y)
    for (int x = 0; x < raster_.size.width; ++x)
      result.rays.push_back(ray_in_camera(
          raster_.lens, (raster_.first_pixel + Eigen::Vector2i(x, y)).cast<double>()));
  return result;
}

template <typename Use>
void Canvas::paint(Use&& use) const {
  ImageF light({size_.width, kBandRows});
  CoverageBand coverage(size_.width, kBandRows);
  const std::vector<std::uint64_t> everywhere(coverage.passed(0).size(), ~std::uint64_t{0});
  for (int band = 0; band * kBandRows < size_.height; ++band) {
    coverage.move_to(band * kBandRows);
    std::fill_n(light.row(0), light.pixels().size(), background_);
    const PixelRays rays = is_shaded_ ? rays_of(band) : PixelRays();
    for (const BandedLayer& layer : layers_) add(layer, band, rays, coverage, light);
    const int rows = std::min(kBandRows, size_.height - band * kBandRows);
    for (int r = 0; r < rows; ++r)
      use(band * kBandRows + r, light.row(r),
          is_shaded_ ? std::span<const std::uint64_t>(everywhere) : coverage.passed(r));
  }
}

template <typename AddRun>
void Canvas::add_areas(const Bands& bands, int band, CoverageBand& coverage,
                       AddRun&& add_run) const {
  coverage.accumulate(bands[static_cast<std::size_t>(band)]);
  coverage.drain(add_run);
}

void Canvas::add(const BandedLayer& layer, int band, const PixelRays& rays, CoverageBand& coverage,
                 ImageF& light) const {
  const auto uniform = [&](float level) {
    return [&light, level](int r, int first, int last, float share) {
      float* levels = light.row(r);
      const float step = share * level;
      for (int c = first; c < last; ++c) levels[c] += step;
    };
  };
  const auto shaded = [&, scale = raster_.scale](float level, float below) {
    return [&, scale, level, below](int r, int first, int last, float share) {
      const int y = (band * kBandRows + r) / scale - rays.first_row;
      for (int c = first; c < last;) {
        const int x = c / scale, end = std::min(last, (x + 1) * scale);
        const auto& ray = rays.rays[static_cast<std::size_t>(y * raster_.size.width + x)];
        const double factor = ray ? layer.shading.at(*ray) : layer.shading.uniform();
        const float step = share * (static_cast<float>(factor) * level - below);
        for (; c < end; ++c) light.row(r)[c] += step;
      }
    };
  };
  const float ink_step = layer.ink_level - layer.paper_level;
  if (layer.shading.is_uniform()) {
    add_areas(layer.paper, band, coverage, uniform(layer.paper_level - background_));
    add_areas(layer.ink, band, coverage, uniform(ink_step));
  } else {
    add_areas(layer.paper, band, coverage, shaded(layer.paper_level, background_));
    add_areas(layer.ink, band, coverage, shaded(ink_step, 0));
  }
}

ImageF Canvas::sampled(double blur_px, float factor) const {
  ImageF image(raster_.size);
  if (blur_px <= 0) {
    paint([&](int y, const float* levels, auto) {
      std::transform(levels, levels + size_.width, image.row(y),
                     [factor](float level) { return factor * level; });
    });
    return image;
  }
  Blur filter(blur_px, raster_.scale, factor, image);
  paint([&](int, const float* levels, auto passed) { filter.add_row(levels, passed); });
  filter.finish();
  return image;
}

}  // namespace tagcal::internal
