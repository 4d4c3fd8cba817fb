#pragma once

#include "tagcal/scene/raster/painter.hpp"

namespace tagcal::internal {

// The light of a scene through a thin lens, times the exposure. At each pixel a sheet is blurred by
// the defocus of the depth that the pixel's ray meets in its plane: exact for a sheet parallel to
// the image. Sheets are composited from near to far, whole, as if there were no others: the blurred
// border of a near sheet shows what is behind it. Sheets with a common edge, and those that hide
// each other in turn or cut each other, are one layer with what the eye sees of each, and a pixel
// has one blur for it: borders between two depths of a layer are approximate. The sensor has a
// focus, and the lens is a perspective.
ImageF render_in_focus(const Scene& scene, const TagFamilies& families,
                       const Pose& camera_from_world);

}  // namespace tagcal::internal
