#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/scene/image.hpp"

namespace tagcal {

// All functions that read take frames of videos and bags, too, by paths as "clip.mp4@000123"
// (sequence_file.hpp); those are read in 8 bits.

// Reads a PNG, JPEG, TIFF (the first page), BMP, WebP, HEIC, AVIF, PGM or PPM picture (recognised
// by its first bytes, not by its name) as 8-bit grey. Colour becomes grey by Rec. 601 luma; alpha
// is ignored. 16-bit values are scaled so that white is the brightest value, or twice the 99.9 %
// quantile if that is less: a lamp or a hot pixel must not make all others dark. The picture is
// rotated and mirrored as the Exif tag Orientation of a JPEG, PNG, TIFF or WebP says, as by
// cv::imread; an unreadable tag is ignored. Throws Error, naming the file: missing, empty,
// truncated, not a picture, more than 100 megapixels.
Image8 read_image(const std::filesystem::path& file);

// The same of a file's bytes, such as those of a camera's stream. Errors have no name.
Image8 decode_image(std::string_view bytes);

// A 16-bit picture as read_image scales it, for the functions that search 8 bits.
Image8 scaled_to_8_bits(const ImageView16& image);

// Reads the same files in their own kind: grey or colour, 8 or 16 bits. 16-bit values are as
// stored; fewer than 8 bits are scaled to 255. Alpha is ignored. A palette of greys is grey.
// Rotates and throws as read_image does.
Picture read_picture(const std::filesystem::path& file);

// The same at a reduced size, for small copies: a JPEG at half, a quarter or an eighth of its size,
// decoded in less time, if that divides both sides and the result is at least `least_width` wide.
// A pixel is then the mean of a square of pixels, but for detail that the JPEG's blocks cut off.
// Other pictures have their full size.
Picture read_reduced(const std::filesystem::path& file, int least_width);

struct ImageHeader {
  ImageSize size;       // as read_image returns the picture
  int orientation = 1;  // Exif's, 1 to 8, by which it is turned; 1 for frames
};

// From the parts of the file that are needed, without the pixels.
ImageHeader read_image_header(const std::filesystem::path& file);
ImageSize read_image_size(const std::filesystem::path& file);

// Throws Error for a side below 1 px and for more than 100 megapixels, as the readers do.
void check_pixel_count(std::int64_t width, std::int64_t height);

// Returns true for a name that ends as those of pictures do: .png, .jpg, .jpeg, .tif, .tiff, .bmp,
// .webp, .heic, .heif, .avif, .pgm, .ppm, in any case.
bool is_picture_name(const std::filesystem::path& file);

// The files of a folder that have a picture's name, sorted by name; hidden files are not among
// them. Throws Error if it is not a folder that can be read.
std::vector<std::filesystem::path> list_pictures(const std::filesystem::path& folder);

// Writes an 8-bit grey PNG, whole or not at all. Throws Error if that fails. A resolution above 0
// is written into the file, for printing true to scale.
void write_png(const std::filesystem::path& file, const Image8& image, double pixels_per_inch = 0);

// The same with 16-bit values, unscaled, and in colour.
void write_png(const std::filesystem::path& file, const Image16& image);
void write_png(const std::filesystem::path& file, const ImageRgb& image);
void write_png(const std::filesystem::path& file, const ImageRgb16& image);

// The bytes of a JPEG file of quality 1 to 100. Throws Error for 16-bit pictures and a size of
// zero.
std::string jpeg_bytes(const Picture& picture, int quality);

// Writes a picture whole or not at all, as the end of the file's name says (in any case): .png,
// .tif, .tiff, .jpg or .jpeg (8-bit; of quality 95), .pgm (grey) or .ppm. Throws Error for another
// end, for a size of zero, and if it cannot be written.
void write_picture(const std::filesystem::path& file, const Picture& picture);

}  // namespace tagcal
