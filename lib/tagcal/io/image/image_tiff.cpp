#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/io/image/image_codec.hpp"
#include "tagcal/io/image/tiff_memory.hpp"

namespace tagcal::internal {
namespace {

// Those of pictures of cameras and scanners. The decoder of JBIG ends the program for a size that
// it cannot allocate, which stands in the data.
constexpr std::array kCompressions = {
    COMPRESSION_NONE,     COMPRESSION_CCITTRLE, COMPRESSION_CCITTFAX3,     COMPRESSION_CCITTFAX4,
    COMPRESSION_LZW,      COMPRESSION_JPEG,     COMPRESSION_ADOBE_DEFLATE, COMPRESSION_DEFLATE,
    COMPRESSION_PACKBITS, COMPRESSION_LZMA,     COMPRESSION_ZSTD,          COMPRESSION_WEBP};

constexpr int kCfa = 32803;        // Photometric of raw pictures (TIFF/EP, DNG)
constexpr int kLinearRaw = 34892;  // Photometric of DNG

struct Layout {
  int bits = 1;
  int samples = 1;  // of a pixel
  int photometric = PHOTOMETRIC_MINISBLACK;
  bool separate_planes = false;
  bool tiled = false;
  int block_width = 0;  // of a tile or strip, px
  int block_height = 0;
};

const char* name_of_photometric(int photometric) {
  switch (photometric) {
    case PHOTOMETRIC_SEPARATED:
      return "CMYK";
    case PHOTOMETRIC_CIELAB:
    case PHOTOMETRIC_ICCLAB:
    case PHOTOMETRIC_ITULAB:
      return "Lab";
    case PHOTOMETRIC_YCBCR:
      return "YCbCr without JPEG";
    case PHOTOMETRIC_LOGL:
    case PHOTOMETRIC_LOGLUV:
      return "logarithmic";
    case kCfa:
    case kLinearRaw:
      return "raw (sensor data)";
    default:
      return "of an unknown kind";
  }
}

// The first picture of a file, read strip by strip or tile by tile.
class TiffDecoder : public ImageDecoder {
 public:
  explicit TiffDecoder(std::string_view bytes)
      : num_bytes_(bytes.size()), memory_(bytes), tiff_(open_tiff(memory_, "r")) {
    if (!tiff_) throw failure();
    read_size();
    read_layout();
    check_layout();
    header_.sixteen_bit = layout_.bits == 16;
    header_.channels = layout_.photometric == PHOTOMETRIC_RGB ? 3 : 1;
    if (layout_.photometric == PHOTOMETRIC_PALETTE) read_palette();
  }

  void decode(const RowSink& sink) override {
    memory_.forget_warnings();  // about tags
    const auto row_values = static_cast<std::size_t>(header_.width * header_.channels);
    const int band_height = std::min(layout_.block_height, header_.height);
    block_.resize(static_cast<std::size_t>(layout_.tiled ? TIFFTileSize(tiff_.get())
                                                         : TIFFStripSize(tiff_.get())));
    std::vector<std::uint16_t> band(row_values * static_cast<std::size_t>(band_height));
    for (int y0 = 0; y0 < header_.height; y0 += band_height) {
      const int rows = std::min(band_height, header_.height - y0);
      read_band(y0, rows, band);
      for (int y = 0; y < rows; ++y)
        sink(y0 + y, band.data() + static_cast<std::size_t>(y) * row_values);
    }
  }

 private:
  Error failure() const {
    return Error("TIFF: is damaged or truncated" +
                 (memory_.error().empty() ? "" : ": " + memory_.error()));
  }

  int field(std::uint32_t tag) const {
    std::uint16_t value = 0;
    TIFFGetFieldDefaulted(tiff_.get(), tag, &value);
    return value;
  }

  void read_size() {
    std::uint32_t width = 0, height = 0, kind = 0;
    TIFFGetField(tiff_.get(), TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff_.get(), TIFFTAG_IMAGELENGTH, &height);
    check_picture_size(width, height, num_bytes_);
    header_.width = static_cast<int>(width);
    header_.height = static_cast<int>(height);
    const int orientation = field(TIFFTAG_ORIENTATION);
    header_.orientation = orientation >= 1 && orientation <= 8 ? orientation : 1;
    TIFFGetFieldDefaulted(tiff_.get(), TIFFTAG_SUBFILETYPE, &kind);
    if ((kind & FILETYPE_REDUCEDIMAGE) != 0) {
      throw Error(
          "TIFF: the first picture is a thumbnail, as in raw files of cameras: convert the file to "
          "a PNG or TIFF of full size");
    }
  }

  void read_layout() {
    TIFF* tiff = tiff_.get();
    layout_.bits = field(TIFFTAG_BITSPERSAMPLE);
    layout_.samples = field(TIFFTAG_SAMPLESPERPIXEL);
    layout_.separate_planes = field(TIFFTAG_PLANARCONFIG) == PLANARCONFIG_SEPARATE;
    std::uint16_t photometric = 0;
    if (TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric) == 0)
      photometric = layout_.samples >= 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK;
    const bool jpeg = field(TIFFTAG_COMPRESSION) == COMPRESSION_JPEG;
    if (jpeg && photometric == PHOTOMETRIC_YCBCR) {
      TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
      photometric = PHOTOMETRIC_RGB;
    }
    layout_.photometric = photometric;
    layout_.tiled = TIFFIsTiled(tiff) != 0;
    std::uint32_t width = static_cast<std::uint32_t>(header_.width), height = 0;
    TIFFGetFieldDefaulted(tiff, layout_.tiled ? TIFFTAG_TILELENGTH : TIFFTAG_ROWSPERSTRIP, &height);
    if (layout_.tiled)
      TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &width);
    else
      height = std::min(height, static_cast<std::uint32_t>(header_.height));
    check_picture_size(width, height, num_bytes_);
    check_padding(width, height);
    layout_.block_width = static_cast<int>(width);
    layout_.block_height = static_cast<int>(height);
  }

  // Whole tiles are decoded, also where they reach beyond the picture.
  void check_padding(std::int64_t width, std::int64_t height) const {
    const auto padded = [](std::int64_t size, std::int64_t block) {
      return (size + block - 1) / block * block;
    };
    const std::int64_t across = padded(header_.width, width), down = padded(header_.height, height);
    if (across * down > 2 * std::int64_t{header_.width} * header_.height)
      check_picture_size(across, down, num_bytes_);
  }

  void check_layout() const {
    const int compression = field(TIFFTAG_COMPRESSION);
    const bool is_read = std::ranges::find(kCompressions, compression) != kCompressions.end();
    if (!is_read || TIFFIsCODECConfigured(static_cast<std::uint16_t>(compression)) == 0)
      throw Error(fmt::format("TIFF: its compression ({}) is not known", compression));
    const int format = field(TIFFTAG_SAMPLEFORMAT);
    if (format != SAMPLEFORMAT_UINT && format != SAMPLEFORMAT_VOID)
      throw Error("TIFF: values must be whole numbers from 0, got floating-point or signed ones");
    const int bits = layout_.bits;
    const bool colour = layout_.photometric == PHOTOMETRIC_RGB;
    const bool palette = layout_.photometric == PHOTOMETRIC_PALETTE;
    const bool grey = layout_.photometric == PHOTOMETRIC_MINISBLACK ||
                      layout_.photometric == PHOTOMETRIC_MINISWHITE;
    if (!colour && !palette && !grey) {
      throw Error(fmt::format("TIFF: is {}: convert it to grey or RGB",
                              name_of_photometric(layout_.photometric)));
    }
    constexpr int kMostSamples = 5;  // of a pixel: a colour, an alpha, and one more
    if (layout_.samples < (colour ? 3 : 1) || layout_.samples > kMostSamples ||
        (palette && layout_.samples != 1))
      throw Error(fmt::format("TIFF: {} values per pixel do not make a picture", layout_.samples));
    const bool few = bits == 1 || bits == 2 || bits == 4;
    if (bits != 8 && !(bits == 16 && !palette) && !(few && layout_.samples == 1)) {
      throw Error(fmt::format("TIFF: {} bits a value are not read: write 8 or 16", bits));
    }
  }

  // The colours are 16-bit, in some old files 8-bit.
  void read_palette() {
    std::array<std::uint16_t*, 3> map{};
    if (TIFFGetField(tiff_.get(), TIFFTAG_COLORMAP, &map[0], &map[1], &map[2]) == 0)
      throw Error("TIFF: its palette is missing");
    const int count = 1 << layout_.bits;
    const bool eight_bit = std::all_of(map.begin(), map.end(), [&](const std::uint16_t* colour) {
      return std::all_of(colour, colour + count, [](int value) { return value < 256; });
    });
    palette_.resize(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < palette_.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c)
        palette_[i][c] = static_cast<std::uint8_t>(eight_bit ? map[c][i] : map[c][i] >> 8);
    const bool grey = std::all_of(palette_.begin(), palette_.end(), [](const Rgb& colour) {
      return colour[0] == colour[1] && colour[1] == colour[2];
    });
    header_.channels = grey ? 1 : 3;
  }

  // Rows y0 to y0 + rows, of a row of tiles or of one strip, for each plane.
  void read_band(int y0, int rows, std::vector<std::uint16_t>& band) {
    const int planes = layout_.separate_planes && palette_.empty() ? header_.channels : 1;
    for (int plane = 0; plane < planes; ++plane)
      for (int x0 = 0; x0 < header_.width; x0 += layout_.block_width) {
        read_block(x0, y0, rows, plane);
        const int columns = std::min(layout_.block_width, header_.width - x0);
        for (int y = 0; y < rows; ++y) {
          const auto at = static_cast<std::size_t>((y * header_.width + x0) * header_.channels);
          copy_values(y, columns, plane, band.data() + at);
        }
      }
  }

  void read_block(int x0, int y0, int rows, int plane) {
    TIFF* tiff = tiff_.get();
    const auto x = static_cast<std::uint32_t>(x0), y = static_cast<std::uint32_t>(y0);
    const auto sample = static_cast<std::uint16_t>(plane);
    const auto size = static_cast<tmsize_t>(block_.size());
    row_bytes_ = layout_.tiled ? TIFFTileRowSize(tiff) : TIFFScanlineSize(tiff);
    const tmsize_t got =
        layout_.tiled
            ? TIFFReadEncodedTile(tiff, TIFFComputeTile(tiff, x, y, 0, sample), block_.data(), size)
            : TIFFReadEncodedStrip(tiff, TIFFComputeStrip(tiff, y, sample), block_.data(), size);
    // The JPEG library fills missing parts with grey and only warns.
    const bool filled = field(TIFFTAG_COMPRESSION) == COMPRESSION_JPEG && memory_.warned();
    if (got < row_bytes_ * rows || filled) throw failure();
  }

  int value_at(const std::uint8_t* row, std::size_t i) const {
    const auto bits = static_cast<std::size_t>(layout_.bits);
    if (bits == 8) return row[i];
    if (bits == 16) {
      std::uint16_t value = 0;
      std::memcpy(&value, row + 2 * i, sizeof(value));
      return value;
    }
    const std::size_t shift = 8 - bits - i * bits % 8;
    return (row[i * bits / 8] >> shift) & ((1 << bits) - 1);
  }

  // The values of row `y` of the block.
  void copy_values(int y, int columns, int plane, std::uint16_t* out) const {
    const std::uint8_t* row = block_.data() + row_bytes_ * y;
    const auto in_pixel = static_cast<std::size_t>(layout_.separate_planes ? 1 : layout_.samples);
    const auto channels = static_cast<std::size_t>(header_.channels);
    const int white = (1 << layout_.bits) - 1;
    const bool inverted = layout_.photometric == PHOTOMETRIC_MINISWHITE;
    const int scale = layout_.bits < 8 ? 255 / white : 1;  // exact for 1, 2 and 4 bits
    for (std::size_t x = 0; x < static_cast<std::size_t>(columns); ++x, out += channels) {
      if (!palette_.empty()) {
        const Rgb& colour = palette_[static_cast<std::size_t>(value_at(row, x))];
        std::copy_n(colour.begin(), channels, out);
        continue;
      }
      const std::size_t count = layout_.separate_planes ? 1 : channels;
      for (std::size_t c = 0; c < count; ++c) {
        const int value = value_at(row, x * in_pixel + c);
        out[c + static_cast<std::size_t>(plane)] =
            static_cast<std::uint16_t>(scale * (inverted ? white - value : value));
      }
    }
  }

  std::size_t num_bytes_;
  TiffMemory memory_;
  TiffHandle tiff_;  // refers to the memory
  Layout layout_;
  std::vector<Rgb> palette_;  // empty without one
  std::vector<std::uint8_t> block_;
  tmsize_t row_bytes_ = 0;
};

}  // namespace

std::unique_ptr<ImageDecoder> tiff_decoder(std::string_view bytes) {
  return std::make_unique<TiffDecoder>(bytes);
}

}  // namespace tagcal::internal
