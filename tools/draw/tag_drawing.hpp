#pragma once

#include <vector>

#include "tagcal/detect/detector.hpp"
#include "tagcal/scene/dataset.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

// Size of the ellipses in standard deviations.
inline constexpr double kEllipseScale = 100;

// The picture with the outline of every tag, a disc at its corner 0, its id in the middle, a cross
// at each corner and, if its covariance is known, the ellipse of kEllipseScale standard
// deviations. Tags that are not reported have a dashed outline and no crosses.
ImageRgb draw_tags(const Image8& picture, const View& view,
                   const std::vector<UnfittedTag>& unfitted);

// The same for tags without a board.
ImageRgb draw_tags(const Image8& picture, const std::vector<DetectedTag>& tags);

}  // namespace tagcal::tools
