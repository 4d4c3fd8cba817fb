#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tagcal/scene/board.hpp"
#include "tagcal/scene/raster/canvas.hpp"
#include "tagcal/scene/raster/tracer.hpp"
#include "tagcal/scene/surfaces.hpp"

namespace tagcal::internal {

// Makes the layers of one view, in the camera frame.
class Painter {
 public:
  // All must outlive it. Outlines are in cells, `scale` of which are a pixel.
  Painter(const Scene& scene, const TagFamilies& families, const Pose& camera_from_world,
          int scale);

  const Shadows& shadows() const { return shadows_; }

  // What the eye sees of a sheet; in the second form, if there were only the sheets `hidden_by`
  // besides.
  Layer layer_of(std::size_t index) const { return layer_of(index, shadows_.all()); }
  Layer layer_of(std::size_t index, std::span<const std::size_t> hidden_by) const;

 private:
  using Polygon = Shadows::Polygon;

  Shading shading_of(std::size_t index) const;
  std::vector<Polygon> seen_parts(const Polygon& polygon, std::size_t index,
                                  std::span<const std::size_t> hidden_by) const;
  // Adds the cells of a sheet, all of them if `whole`, else what is seen.
  void print(std::size_t index, bool whole, std::span<const std::size_t> hidden_by,
             Outlines& ink) const;

  const Scene& scene_;
  const TagFamilies& families_;
  const Pose& camera_from_world_;
  std::optional<Light> light_;  // in the camera frame
  Tracer tracer_;
  Shadows shadows_;
};

}  // namespace tagcal::internal
