#pragma once

#include <string_view>

#include "tagcal/scene/image.hpp"

// Private to io: cameras store pictures as the sensor lies, and the turn that makes them upright in
// the Exif tag Orientation.
namespace tagcal::internal {

// The tag's value, 1 to 8, of a PNG's or JPEG's bytes: from the chunk eXIf of the one, the segment
// APP1 of the other. 1 (as stored) where there is none, or none that can be read.
int exif_orientation(std::string_view picture);

inline bool swaps_sides(int orientation) { return orientation >= 5; }

// The picture as it is to be seen: what cv::imread gives. `orientation` 1 to 8.
Image8 upright(Image8 stored, int orientation);

}  // namespace tagcal::internal
