#pragma once

#include <string_view>

#include "tagcal/scene/image.hpp"

// Private to io: cameras store pictures in the orientation of the sensor, and the rotation that
// makes them upright in the Exif tag Orientation.
namespace tagcal::internal {

// The tag's value, 1 to 8, from the bytes of a picture: of a PNG (chunk eXIf), a JPEG (segment
// APP1) or a WebP (chunk EXIF). 1 (as stored) if it is missing or unreadable.
int png_orientation(std::string_view picture);
int jpeg_orientation(std::string_view picture);
int webp_orientation(std::string_view picture);

inline bool swaps_sides(int orientation) { return orientation >= 5; }

// The upright picture, as cv::imread returns it. `orientation`: 1 to 8. For each kind of Picture.
template <typename T>
Image<T> upright(Image<T> stored, int orientation);

}  // namespace tagcal::internal
