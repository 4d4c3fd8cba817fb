#pragma once

#include <filesystem>

#include "tagcal/scene/image.hpp"

namespace tagcal {

// Reads a PNG, JPEG or PGM picture (told by its first bytes, not by its name) as 8-bit grey. Colour
// becomes grey by Rec. 601 luma; alpha is left out. 16-bit values are scaled so that the brightest
// stays in range, but no lamp or hot pixel leaves the rest in the dark: what is brighter than twice
// the value that 999 of 1000 pixels keep below is white.
// What the Exif tag Orientation of a JPEG or PNG turns or mirrors is turned and mirrored, as by
// cv::imread; one that cannot be read counts as none.
// Throws Error, naming the file: missing, empty, truncated, not a picture, more than 100
// megapixels.
Image8 read_image(const std::filesystem::path& file);

// The size of a picture as read_image gives it, from its header alone.
ImageSize read_image_size(const std::filesystem::path& file);

// Writes an 8-bit grey PNG, whole or not at all. Throws Error where it cannot. A resolution above 0
// is noted in the file, for printing true to scale.
void write_png(const std::filesystem::path& file, const Image8& image, double pixels_per_inch = 0);

// The same with 16-bit values, as they are.
void write_png(const std::filesystem::path& file, const Image16& image);

// The same in colour.
void write_png(const std::filesystem::path& file, const ImageRgb& image);

}  // namespace tagcal
