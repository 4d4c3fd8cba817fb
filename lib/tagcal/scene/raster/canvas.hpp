#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tagcal/scene/light/shading.hpp"
#include "tagcal/scene/raster/coverage.hpp"

namespace tagcal::internal {

// What the eye sees of a surface: paper, and ink on the paper.
struct Layer {
  Outlines paper;
  Outlines ink;
  float paper_level = 0;
  float ink_level = 0;
  Shading shading;  // both levels are multiplied by it
};

// A rectangle of pixels that is painted with `scale` x `scale` cells a pixel.
struct Raster {
  const Lens& lens;
  Eigen::Vector2i first_pixel;
  ImageSize size;
  int scale = 1;

  ImageSize cells() const { return {size.width * scale, size.height * scale}; }
};

// Number of raster cells per pixel: 1 without blur, because areas are exact; with blur the Gaussian
// must be wide compared with the cells (edges are right to 2e-3 of their contrast).
int raster_scale(double blur_px);

// Adds up layers, which cover no point twice, one band of the raster after the other. The shading
// by a point lamp is that at the centre of each pixel, for all of its cells: within a pixel only
// the area is exact.
class Canvas {
 public:
  // Outlines are in cells of the raster. The lens must outlive it.
  Canvas(const std::vector<Layer>& layers, float background, const Raster& raster);

  // The levels of the pixels times a factor, after a Gaussian blur (none at 0).
  ImageF sampled(double blur_px, float factor) const;

 private:
  // The edges in each band.
  using Bands = std::vector<std::vector<Outlines::Edge>>;

  struct BandedLayer {
    Bands paper;
    Bands ink;
    float paper_level;
    float ink_level;
    Shading shading;
  };

  // The rays of the pixels that a band meets, of which the first row is first_row.
  struct PixelRays {
    int first_row = 0;
    std::vector<std::optional<Ray>> rays;
  };

  // Calls use(row, levels, passed) for every row of the raster, from the top; the level changes
  // only in blocks of cells in `passed`.
  template <typename Use>
  void paint(Use&& use) const;

  Bands by_band(const Outlines& outlines) const;
  PixelRays rays_of(int band) const;
  void add(const BandedLayer& layer, int band, const PixelRays& rays, CoverageBand& coverage,
           ImageF& light) const;
  template <typename AddRun>
  void add_areas(const Bands& bands, int band, CoverageBand& coverage, AddRun&& add_run) const;

  float background_;
  Raster raster_;
  ImageSize size_;          // of the raster, in cells
  bool is_shaded_ = false;  // a layer's shading differs from pixel to pixel
  std::vector<BandedLayer> layers_;
};

}  // namespace tagcal::internal
