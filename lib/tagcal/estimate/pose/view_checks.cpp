#include "tagcal/estimate/pose/view_checks.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>

#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal::internal {

using Eigen::Vector2d;

bool is_mirrored(std::span<const CornerId> ids, std::span<const Correspondence> correspondences) {
  const bool has_tags = std::ranges::any_of(ids, [](const CornerId& id) { return id.corner != 0; });
  if (!has_tags) return false;
  struct Quad {
    std::array<Vector2d, 4> corners;
    int count = 0;
  };
  std::map<int, Quad> quads;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const auto corner = static_cast<std::size_t>(ids[i].corner);
    if (corner >= 4) continue;  // of no tag
    Quad& quad = quads[ids[i].tag_id];
    quad.corners[corner] = correspondences[i].pixel;
    ++quad.count;
  }
  int complete = 0, mirrored = 0;
  for (const auto& [tag, quad] : quads) {
    if (quad.count < 4) continue;
    const Vector2d a = quad.corners[2] - quad.corners[0], b = quad.corners[3] - quad.corners[1];
    ++complete;
    mirrored += a.x() * b.y() - a.y() * b.x() > 0;  // y points down: anticlockwise is negative
  }
  return complete > 0 && !policy::is_below(mirrored, policy::kMirroredTags, complete);
}

std::size_t num_outside(std::span<const Correspondence> correspondences, const ImageSize& size) {
  constexpr double kHalf = 0.5;  // numeric: the border is half a pixel beyond its pixels' centres
  const Eigen::AlignedBox2d image(Vector2d(-kHalf, -kHalf),
                                  Vector2d(size.width - kHalf, size.height - kHalf));
  return static_cast<std::size_t>(std::ranges::count_if(
      correspondences, [&](const Correspondence& c) { return !image.contains(c.pixel); }));
}

std::optional<Finding> corners_outside(std::size_t num_outside, std::size_t num_corners,
                                       const ImageSize& size) {
  if (!policy::is_above(num_outside, policy::kMostOutsideImage, num_corners)) return std::nullopt;
  return finding(code::corners_outside,
                 fmt::format("{} of {} corners lie outside of the image of {}x{} pixels: its size "
                             "is wrong, or they are of pictures of another size",
                             num_outside, num_corners, size.width, size.height));
}

void say_mirror_image_fits(std::vector<Finding>& findings) {
  std::ranges::find(findings, Severity::refusal, &Finding::severity)->sentence =
      "the points of the target fit only in their mirror image: change the sign of one coordinate "
      "of all points, so that x, y and z are right-handed";
}

}  // namespace tagcal::internal
