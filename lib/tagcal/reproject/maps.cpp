#include "tagcal/reproject/maps.hpp"

#include <algorithm>

#include "tagcal/internal/parallel.hpp"
#include "tagcal/reproject/policy/policy.hpp"
#include "tagcal/reproject/rows/map_rows.hpp"

namespace tagcal {
using namespace internal;

namespace {

// The lens with its principal point moved.
template <typename L>
Lens moved(const L& lens, int x, int y) {
  auto p = lens.parameters();
  p[2] -= x;  // cx, cy in every lens
  p[3] -= y;
  return L(p);
}

}  // namespace

Target cropped(const Target& target, int x, int y, const ImageSize& size) {
  Target part = target;
  if (auto* camera = std::get_if<Camera>(&part)) {
    camera->lens = std::visit([&](const auto& lens) { return moved(lens, x, y); }, camera->lens);
    camera->image_size = size;
  } else if (auto* panorama = std::get_if<Panorama>(&part)) {
    panorama->centre -= Eigen::Vector2d(x, y);
    panorama->size = size;
  } else {
    PlaneRaster& plane = std::get<PlaneRaster>(part);
    plane.upper_left += plane.m_per_px * Eigen::Vector2d(x, -y);
    plane.size = size;
  }
  return part;
}

std::optional<Eigen::Vector2d> source_pixel(const Reprojection& reprojection,
                                            const Eigen::Vector2d& target_pixel) {
  return map_rows(reprojection).at(target_pixel);
}

PixelMap pixel_map(const Reprojection& reprojection, int threads) {
  const MapRows rows = map_rows(reprojection);
  PixelMap map{ImageF(rows.size), ImageF(rows.size)};
  const int bands = (rows.size.height + policy::kBlock - 1) / policy::kBlock;
  parallel_for(static_cast<std::size_t>(bands), threads, [&](std::size_t band) {
    const int begin = static_cast<int>(band) * policy::kBlock;
    const int end = std::min(begin + policy::kBlock, rows.size.height);
    for (int v = begin; v < end; ++v) rows.fill(v, map.x.row(v), map.y.row(v));
  });
  return map;
}

}  // namespace tagcal
