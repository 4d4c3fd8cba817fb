#pragma once

#include <tiffio.h>
#include <webp/encode.h>

#include <cmath>
#include <string>
#include <vector>

#include "file_fixture.hpp"
#include "tagcal/io/image_file.hpp"

// TIFF, BMP and WebP, of the kinds that other programs write.

namespace tagcal {

struct TiffKind {
  int bits = 8;
  int samples = 1;
  int photometric = PHOTOMETRIC_MINISBLACK;
  int compression = COMPRESSION_NONE;
  bool tiled = false;
  bool separate = false;
  const char* mode = "w";
  int orientation = 1;
  int format = SAMPLEFORMAT_UINT;
  int kind = 0;  // 1: a thumbnail
};

// `values`: of all samples of all pixels, row by row. Of 8 or 16 bits, or the packed bytes of a row
// for fewer.
inline std::string tiff_of(const fs::path& file, const ImageSize& size,
                           const std::vector<std::uint16_t>& values, const TiffKind& k) {
  TIFF* tiff = TIFFOpen(file.c_str(), k.mode);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, size.width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, size.height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, k.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, k.samples);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, k.photometric);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, k.compression);
  TIFFSetField(tiff, TIFFTAG_ORIENTATION, k.orientation);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, k.format);
  TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, k.kind);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG,
               k.separate ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
  if (k.compression == COMPRESSION_JPEG) {
    TIFFSetField(tiff, TIFFTAG_JPEGQUALITY, 98);
    if (k.photometric == PHOTOMETRIC_YCBCR)
      TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
  }
  if (k.photometric == PHOTOMETRIC_PALETTE) {
    std::vector<std::uint16_t> map[3];
    for (int i = 0; i < 256; ++i)
      for (int c = 0; c < 3; ++c) map[c].push_back(static_cast<std::uint16_t>(257 * (255 - i)));
    map[0][0] = 0;  // a colour
    TIFFSetField(tiff, TIFFTAG_COLORMAP, map[0].data(), map[1].data(), map[2].data());
  }
  const int width = k.tiled ? 16 : size.width,
            height = k.tiled ? 16 : 8;  // of JPEG: multiples of 8
  if (k.tiled) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, width);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, height);
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, height);
  }
  const int in_block = k.separate ? 1 : k.samples;
  const int row_values = k.bits < 8 ? (size.width * k.bits + 7) / 8 : size.width * k.samples;
  for (int plane = 0; plane < (k.separate ? k.samples : 1); ++plane)
    for (int y0 = 0; y0 < size.height; y0 += height)
      for (int x0 = 0; x0 < size.width; x0 += width) {
        std::string block;
        for (int y = y0; y < y0 + height; ++y) {
          if (!k.tiled && y == size.height) break;
          for (int i = 0; i < (k.bits < 8 ? row_values : width * in_block); ++i) {
            const int x = k.bits < 8 ? i : (x0 + i / in_block) * k.samples + plane + i % in_block;
            const bool inside = y < size.height && x < row_values;
            const int value = inside ? values[static_cast<std::size_t>(y * row_values + x)] : 0;
            if (k.bits == 16)
              block.append(std::string{static_cast<char>(value), static_cast<char>(value >> 8)});
            else
              block += static_cast<char>(value);
          }
        }
        const auto x = static_cast<std::uint32_t>(x0), y = static_cast<std::uint32_t>(y0);
        const auto s = static_cast<std::uint16_t>(plane);
        const auto n = static_cast<tmsize_t>(block.size());
        if (k.tiled)
          TIFFWriteEncodedTile(tiff, TIFFComputeTile(tiff, x, y, 0, s), block.data(), n);
        else
          TIFFWriteEncodedStrip(tiff, TIFFComputeStrip(tiff, y, s), block.data(), n);
      }
  TIFFClose(tiff);
  return read_text(file);
}

inline std::vector<std::uint16_t> smooth_values(const ImageSize& size, int samples, int scale) {
  std::vector<std::uint16_t> values;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      for (int c = 0; c < samples; ++c)
        values.push_back(static_cast<std::uint16_t>(
            scale * (128 + 100 * std::sin(0.1 * x + c) * std::cos(0.1 * y))));
  return values;
}

// The values of the first `channels` samples of each pixel.
inline std::vector<int> values_of(const Picture& picture) {
  std::vector<int> values;
  std::visit(
      [&](const auto& image) {
        for (const auto& pixel : image.pixels()) {
          if constexpr (std::is_arithmetic_v<std::decay_t<decltype(pixel)>>)
            values.push_back(pixel);
          else
            values.insert(values.end(), pixel.begin(), pixel.end());
        }
      },
      picture);
  return values;
}

inline std::string little_endian(std::uint32_t value, int count) {
  std::string bytes;
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> (8 * i));
  return bytes;
}

// An uncompressed BMP of `bits` with its palette; `rows` from the lowest, padded to four bytes.
inline std::string bmp_of(int width, int height, int bits, const std::string& palette,
                          const std::string& rows) {
  const auto n = [](std::size_t value) {
    return little_endian(static_cast<std::uint32_t>(value), 4);
  };
  return "BM" + n(54 + palette.size() + rows.size()) + n(0) + n(54 + palette.size()) + n(40) +
         n(static_cast<std::size_t>(width)) + n(static_cast<std::size_t>(height)) +
         little_endian(1, 2) + little_endian(static_cast<std::uint32_t>(bits), 2) + n(0) + n(0) +
         n(0) + n(0) + n(palette.size() / 4) + n(0) + palette + rows;
}

inline std::string webp_of(const ImageRgb& image) {
  std::uint8_t* bytes = nullptr;
  const std::size_t size = WebPEncodeLosslessRGB(image.pixels().front().data(), image.width(),
                                                 image.height(), 3 * image.width(), &bytes);
  std::string text(reinterpret_cast<char*>(bytes), size);
  WebPFree(bytes);
  return text;
}

inline ImageRgb colours() {
  ImageRgb image({21, 13});
  for (int y = 0; y < 13; ++y)
    for (int x = 0; x < 21; ++x)
      image(x, y) = {static_cast<std::uint8_t>(12 * x), static_cast<std::uint8_t>(19 * y), 77};
  return image;
}

}  // namespace tagcal
