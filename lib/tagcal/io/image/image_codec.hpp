#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "tagcal/scene/image.hpp"

// Private to io: the picture formats behind one interface. All functions throw Error without the
// file's name; image_file.cpp adds it.

namespace tagcal::internal {

// The unsigned number of `count` bytes at a place; no value beyond the end.
std::optional<std::uint64_t> number_at(std::string_view bytes, std::uint64_t at, std::size_t count,
                                       bool big_endian);

// Throws Error for a side below 1 px and for more than 100 megapixels.
void check_picture_size(std::int64_t width, std::int64_t height);
// The same, and for more than 4 megapixels that no file of so few bytes holds.
void check_picture_size(std::int64_t width, std::int64_t height, std::size_t num_bytes);

// A picture in memory, after its header was read and its size was checked.
class ImageDecoder {
 public:
  struct Header {
    int width = 0;
    int height = 0;
    int channels = 1;  // 1: grey; 3: red, green, blue
    bool sixteen_bit = false;
    int white = 255;      // the value of white, unless the values are 16-bit
    int orientation = 1;  // Exif's, 1 to 8 (png_orientation)
  };
  // `row` has width * channels values.
  using RowSink = std::function<void(int y, const std::uint16_t* row)>;

  virtual ~ImageDecoder() = default;
  const Header& header() const { return header_; }

  // Passes on the rows from the top, with the header's channels. Call one of both functions, once.
  virtual void decode(const RowSink& sink) = 0;

  // The same as grey: Rec. 601 luma of the stored values.
  virtual void decode_grey(const RowSink& sink);

 protected:
  Header header_;
};

// `bytes` must live as long as the decoder. They begin as the format's files do.
std::unique_ptr<ImageDecoder> png_decoder(std::string_view bytes);
std::unique_ptr<ImageDecoder> jpeg_decoder(std::string_view bytes);
// The same at half, a quarter or an eighth of the size, if that divides both sides and leaves an
// upright picture at least `least_width` wide. Its header has the reduced size.
std::unique_ptr<ImageDecoder> reduced_jpeg_decoder(std::string_view bytes, int least_width);
bool is_jpeg(std::string_view bytes);
std::unique_ptr<ImageDecoder> netpbm_decoder(std::string_view bytes);
std::unique_ptr<ImageDecoder> tiff_decoder(std::string_view bytes);
std::unique_ptr<ImageDecoder> bmp_decoder(std::string_view bytes);
std::unique_ptr<ImageDecoder> webp_decoder(std::string_view bytes);
// HEIC, HEIF and AVIF. Throws Error if libheif, which is loaded then, is not installed.
std::unique_ptr<ImageDecoder> heif_decoder(std::string_view bytes);

// Decoder of the format that the first bytes name.
std::unique_ptr<ImageDecoder> image_decoder(std::string_view bytes);

template <typename T>
constexpr bool kIsSixteenBit = std::is_same_v<T, std::uint16_t> || std::is_same_v<T, Rgb16>;
template <typename T>
constexpr bool kIsColour = std::is_same_v<T, Rgb> || std::is_same_v<T, Rgb16>;

// The bytes of a file, for each kind of Picture. A resolution above 0 is written into the file.
template <typename T>
std::string encode_png(const Image<T>& image, double pixels_per_inch);
template <typename T>
std::string encode_netpbm(const Image<T>& image);  // PGM or PPM
template <typename T>
std::string encode_tiff(const Image<T>& image);
// 8-bit kinds only. From quality 90 on colour has the full resolution, below half of it.
template <typename T>
std::string encode_jpeg(const Image<T>& image, int quality);

// Cameras store pictures in the orientation of the sensor, and the rotation that makes them upright
// in the Exif tag Orientation. The tag's value, 1 to 8, from the bytes of a picture: of a PNG
// (chunk eXIf), a JPEG (segment APP1) or a WebP (chunk EXIF). 1 (as stored) if it is missing or
// unreadable.
int png_orientation(std::string_view picture);
int jpeg_orientation(std::string_view picture);
int webp_orientation(std::string_view picture);

inline bool swaps_sides(int orientation) { return orientation >= 5; }

// The upright picture, as cv::imread returns it. `orientation`: 1 to 8. For each kind of Picture.
template <typename T>
Image<T> upright(Image<T> stored, int orientation);

// Pictures of decoders, turned upright. Each takes what a decoder passes on, once.
Image8 decode_grey8(ImageDecoder& decoder);            // as read_image
Picture decode_picture(ImageDecoder& decoder);         // as read_picture
Image8 scaled_by_brightest(const ImageView16& image);  // as scaled_to_8_bits

}  // namespace tagcal::internal
