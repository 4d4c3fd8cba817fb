#include "tagcal/detect/tag_fit/known_tag.hpp"

#include <algorithm>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"

namespace tagcal::internal {

TagFitOptions usual_fit_options(const ImageSize& size) {
  const double side =
      std::max({policy::kTagSmallestPicturePx, 1.0 * size.width, 1.0 * size.height});
  TagFitOptions options;
  options.bend_sd_per_px = policy::kTagBendSd / side;
  options.twist_sd_per_px2 = policy::kTagTwistSd / (side * side);
  options.shift_sd_px = policy::kTagShiftSdPx;
  return options;
}

std::optional<TagFit> fit_known_tag(const ImageView8& image, const TagPattern& pattern,
                                    const Quad& start, const KnownTagOptions& known) {
  TagFitOptions options = usual_fit_options(image.size());
  options.camera = known.camera;
  options.is_rough = known.is_rough;
  options.gamma = known.gamma;
  options.is_whole = known.is_whole;
  options.lens_follows = known.lens_follows;
  const TagFit fit = refine_tag(image, pattern, start, options);
  const bool is_start = known.lens_follows && fit.is_by_corner;
  if ((fit.status != TagFitStatus::converged && !is_start) ||
      largest_distance(fit.corners, start) > policy::kTagMaxMovePx)
    return std::nullopt;
  return fit;
}

}  // namespace tagcal::internal
