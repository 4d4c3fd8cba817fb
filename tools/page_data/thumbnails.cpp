#include "page_data/page_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>
#include <variant>

#include "job/progress.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/reproject/resampling.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 480;
constexpr double kPicturesOfFullWidth = 250;  // of more, smaller copies
constexpr int kQuality = 75;
constexpr std::size_t kMostBytes = 10'000'000;  // of all; four thirds of them in the page

std::string base64(std::string_view bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned value = 0;
    for (std::size_t k = 0; k < 3; ++k)
      value = value << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : kDigits[value >> (18 - 6 * k) & 63];
  }
  return text;
}

// The map of a smaller copy of a whole picture.
PixelMap shrinking_map(const ImageSize& from, const ImageSize& to) {
  PixelMap map{ImageF(to), ImageF(to)};
  const double x_ratio = static_cast<double>(from.width) / to.width;
  const double y_ratio = static_cast<double>(from.height) / to.height;
  for (int y = 0; y < to.height; ++y)
    for (int x = 0; x < to.width; ++x) {
      map.x(x, y) = static_cast<float>((x + 0.5) * x_ratio - 0.5);
      map.y(x, y) = static_cast<float>((y + 0.5) * y_ratio - 0.5);
    }
  return map;
}

ImageSize thumbnail_size(const ImageSize& size, int width) {
  width = std::min(width, size.width);
  const double height = static_cast<double>(size.height) * width / size.width;
  return {width, std::max(1, static_cast<int>(std::lround(height)))};
}

Picture shrunk(const Picture& picture, const ImageSize& size) {
  if (size_of(picture) == size) return picture;
  const PixelMap map = shrinking_map(size_of(picture), size);
  return std::visit([&](const auto& image) { return Picture(remap(image, map).image); }, picture);
}

// With eight bits: white of sixteen is found as for detection, over all colours together.
struct EightBits {
  Picture operator()(Image8&& image) const { return std::move(image); }
  Picture operator()(ImageRgb&& image) const { return std::move(image); }
  Picture operator()(Image16&& image) const { return scaled_to_8_bits(image); }
  Picture operator()(ImageRgb16&& image) const {
    const ImageSize values{3 * image.width(), image.height()};
    const Image8 scaled =
        scaled_to_8_bits(ImageView16(image.pixels().front().data(), values, values.width));
    ImageRgb result(image.size());
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x)
        result(x, y) = {scaled(3 * x, y), scaled(3 * x + 1, y), scaled(3 * x + 2, y)};
    return result;
  }
};

Picture read_small(const fs::path& file, int width) {
  return std::visit(EightBits(), read_reduced(file, width));
}

struct Small {
  Picture picture;
  std::string jpeg;
};

Small read_one(const fs::path& file, const ImageSize& image_size, int width, Thumbnail& thumbnail) {
  Small small;
  if (file.empty()) {
    thumbnail.problem = "The picture is not at hand.";
    return small;
  }
  try {
    thumbnail.picture_size = read_image_size(file);
    if (thumbnail.picture_size != image_size) {
      thumbnail.problem =
          fmt::format("The picture is not shown: it is {}x{}, but the calibration is for {}x{}.",
                      thumbnail.picture_size.width, thumbnail.picture_size.height, image_size.width,
                      image_size.height);
      return small;
    }
    thumbnail.size = thumbnail_size(thumbnail.picture_size, width);
    small.picture = shrunk(read_small(file, width), thumbnail.size);
    small.jpeg = jpeg_bytes(small.picture, kQuality);
  } catch (const Error& error) {
    small.jpeg.clear();
    thumbnail.problem = fmt::format("The picture cannot be shown: {}.", error.what());
  }
  return small;
}

std::string uri_of(const std::string& jpeg) { return "data:image/jpeg;base64," + base64(jpeg); }

}  // namespace

std::string jpeg_uri(const Picture& picture) { return uri_of(jpeg_bytes(picture, kQuality)); }

std::vector<Thumbnail> thumbnails(const std::vector<fs::path>& files, const ImageSize& image_size,
                                  int threads) {
  std::vector<Thumbnail> result(files.size());
  std::vector<Small> smalls(files.size());
  const double share =
      kPicturesOfFullWidth / static_cast<double>(std::max<std::size_t>(1, files.size()));
  const int width = std::max(16, static_cast<int>(kWidth * std::sqrt(std::min(1.0, share))));
  {
    Progress progress("thumbnails", static_cast<int>(files.size()));
    parallel_for(
        files.size(), threads,
        [&](std::size_t i) { smalls[i] = read_one(files[i], image_size, width, result[i]); },
        [&](int done, int) { progress.update(done); });
  }
  std::size_t total = 0;
  for (const Small& small : smalls) total += small.jpeg.size();
  const double scale = std::sqrt(static_cast<double>(kMostBytes) /
                                 static_cast<double>(std::max<std::size_t>(total, 1)));
  parallel_for(files.size(), threads, [&](std::size_t i) {
    if (smalls[i].jpeg.empty()) return;
    if (scale < 1) {  // more pictures, or more detail, than a page should have
      result[i].size = thumbnail_size(result[i].size,
                                      std::max(16, static_cast<int>(scale * result[i].size.width)));
      smalls[i].jpeg = jpeg_bytes(shrunk(smalls[i].picture, result[i].size), kQuality);
    }
    result[i].data_uri = uri_of(smalls[i].jpeg);
    smalls[i] = {};
  });
  return result;
}

}  // namespace tagcal::tools
