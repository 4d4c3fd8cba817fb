#include "tagcal/detect/tag_fit/known_tag.hpp"

#include <algorithm>

#include "tagcal/detect/tag_fit/quad.hpp"

namespace tagcal::internal {

std::optional<TagFit> fit_known_tag(const Image8& image, const TagPattern& pattern,
                                    const Quad& start, const KnownTagOptions& known) {
  constexpr double kMaxMove = 2;  // px
  // Ink spreads by up to about 0.15 px, and whites at 2.5 times the full exposure grow by 0.6 px.
  constexpr double kShiftSd = 0.1;
  // Lenses bend lines in proportion to the picture: a fisheye whose picture spans 190 degrees has a
  // focal length of 0.3 of it, and lines of curvature up to 0.6 / f. Curvature in units of one over
  // the longer side, its change along a line in one over its square.
  constexpr double kBendSd = 2;
  constexpr double kTwistSd = 20;
  constexpr double kSmallestPicture = 320;  // px; smaller ones are parts of pictures
  constexpr double kMaxRoughMove = 0.04;    // of a side: a third of a cell
  TagFitOptions options;
  options.camera = known.camera;
  options.is_rough = known.is_rough;
  options.gamma = known.gamma;
  options.is_whole = known.is_whole;
  const double side = std::max({kSmallestPicture, 1.0 * image.width(), 1.0 * image.height()});
  options.bend_sd_per_px = kBendSd / side;
  options.twist_sd_per_px2 = kTwistSd / (side * side);
  options.shift_sd_px = kShiftSd;
  const double max_move =
      known.is_rough ? std::max(kMaxMove, kMaxRoughMove * shortest_side(start)) : kMaxMove;
  const TagFit fit = refine_tag(image, pattern, start, options);
  if (fit.status != TagFitStatus::converged || largest_distance(fit.corners, start) > max_move)
    return std::nullopt;
  return fit;
}

}  // namespace tagcal::internal
