#include "tagcal/detect/known_tag.hpp"

#include "tagcal/detect/quad.hpp"

namespace tagcal {

std::optional<TagFit> fit_known_tag(const Image8& image, const TagPattern& pattern,
                                    const Quad& start, const Camera* camera) {
  constexpr double kMaxMove = 2;  // px
  TagFitOptions options;
  options.camera = camera;
  const TagFit fit = refine_tag(image, pattern, start, options);
  if (fit.status != TagFitStatus::converged || largest_distance(fit.corners, start) > kMaxMove)
    return std::nullopt;
  return fit;
}

}  // namespace tagcal
