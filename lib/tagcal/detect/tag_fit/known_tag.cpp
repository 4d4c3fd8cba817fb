#include "tagcal/detect/tag_fit/known_tag.hpp"

#include <algorithm>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"

namespace tagcal::internal {

TagFitOptions with_usual_priors(TagFitOptions options, const ImageSize& size) {
  const double side =
      std::max({policy::kTagSmallestPicturePx, 1.0 * size.width, 1.0 * size.height});
  options.bend_sd_per_px = policy::kTagBendSd / side;
  options.twist_sd_per_px2 = policy::kTagTwistSd / (side * side);
  options.shift_sd_px = policy::kTagShiftSdPx;
  return options;
}

std::optional<TagFit> fit_known_tag(const ImageView8& image, const TagPattern& pattern,
                                    const Quad& start, const TagFitOptions& options,
                                    double reach_px) {
  const TagFit fit = refine_tag(image, pattern, start, with_usual_priors(options, image.size()));
  const bool is_start = options.lens_follows && fit.is_by_corner;
  if ((fit.status != TagFitStatus::converged && !is_start) ||
      largest_distance(fit.corners, start) > reach_px)
    return std::nullopt;
  return fit;
}

}  // namespace tagcal::internal
