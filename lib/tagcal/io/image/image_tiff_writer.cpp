#include <tiffio.h>

#include <utility>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/io/image/image_codec.hpp"
#include "tagcal/io/image/tiff_memory.hpp"

namespace tagcal::internal {

// Deflate of the differences between neighbours. libtiff replaces a row by its differences, so
// that each row is copied first.
template <typename T>
std::string encode_tiff(const Image<T>& image) {
  TiffMemory memory;
  TiffHandle tiff = open_tiff(memory, "w");
  if (!tiff) throw Error("TIFF: " + memory.error());
  TIFFSetField(tiff.get(), TIFFTAG_IMAGEWIDTH, image.width());
  TIFFSetField(tiff.get(), TIFFTAG_IMAGELENGTH, image.height());
  TIFFSetField(tiff.get(), TIFFTAG_BITSPERSAMPLE, kIsSixteenBit<T> ? 16 : 8);
  TIFFSetField(tiff.get(), TIFFTAG_SAMPLESPERPIXEL, kIsColour<T> ? 3 : 1);
  TIFFSetField(tiff.get(), TIFFTAG_PHOTOMETRIC,
               kIsColour<T> ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff.get(), TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff.get(), TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
  TIFFSetField(tiff.get(), TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL);
  TIFFSetField(tiff.get(), TIFFTAG_ZIPQUALITY, 1);  // as of a PNG: higher levels take longer only
  TIFFSetField(tiff.get(), TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(tiff.get(), 0));
  std::vector<T> row;
  for (int y = 0; y < image.height(); ++y) {
    row.assign(image.row(y), image.row(y) + image.width());
    if (TIFFWriteScanline(tiff.get(), row.data(), static_cast<std::uint32_t>(y)) < 0)
      throw Error("TIFF: " + memory.error());
  }
  if (TIFFFlush(tiff.get()) == 0) throw Error("TIFF: " + memory.error());
  tiff.reset();
  return memory.written();
}

template std::string encode_tiff(const Image8&);
template std::string encode_tiff(const Image16&);
template std::string encode_tiff(const ImageRgb&);
template std::string encode_tiff(const ImageRgb16&);

}  // namespace tagcal::internal
