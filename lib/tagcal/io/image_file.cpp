#include "tagcal/io/image_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "tagcal/error.hpp"
#include "tagcal/io/image/header_copy.hpp"
#include "tagcal/io/image/image_codec.hpp"
#include "tagcal/io/sequence/frame_sequence.hpp"
#include "tagcal/io/sequence_file.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal {
using namespace internal;
namespace {

constexpr std::string_view kPictureKinds[] = {".png",  ".jpg", ".jpeg", ".tif",  ".tiff", ".bmp",
                                              ".webp", ".pgm", ".ppm",  ".heic", ".heif", ".avif"};
constexpr int kQuality = 95;  // of JPEG files

// The size of a file that may be a picture.
std::size_t checked_size(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw Error("no such file");
  if (std::filesystem::is_directory(status)) throw Error("is a folder, not a picture");
  if (!std::filesystem::is_regular_file(status)) throw Error("is not a regular file");
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw Error("cannot be read: " + error.message());
  if (size == 0) throw Error("is empty");
  if (size > limits::kMaxPictureBytes) throw Error("is larger than 1 GiB");
  return static_cast<std::size_t>(size);
}

class OpenPicture {
 public:
  // Not waiting, as opening a pipe would if one took the place of the file that was checked.
  explicit OpenPicture(const std::filesystem::path& file)
      : size_(checked_size(file)),
        descriptor_(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
    if (descriptor_ < 0) throw Error(std::string("cannot be read: ") + std::strerror(errno));
  }
  ~OpenPicture() { ::close(descriptor_); }
  OpenPicture(const OpenPicture&) = delete;
  OpenPicture& operator=(const OpenPicture&) = delete;

  std::size_t size() const { return size_; }
  int descriptor() const { return descriptor_; }

 private:
  std::size_t size_;
  int descriptor_;
};

std::string read_bytes(const std::filesystem::path& file) {
  const OpenPicture open(file);
  std::string bytes(open.size(), '\0');
  read_part(open.descriptor(), 0, bytes);
  return bytes;
}

// Runs a reader or a writer and adds the file's name to its errors.
template <typename Function>
auto naming(const std::filesystem::path& file, Function function) {
  try {
    return function();
  } catch (const Error& error) {
    throw Error(file.string() + ": " + error.what());
  }
}

template <typename T>
void write_as_png(const std::filesystem::path& file, const Image<T>& image,
                  double pixels_per_inch = 0) {
  write_whole(file, naming(file, [&] {
                check_picture_size(image.width(), image.height());
                return encode_png(image, pixels_per_inch);
              }));
}

std::string lower_case(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

// The bytes of a file whose name ends in `kind`.
template <typename T>
std::string encoded(const std::string& kind, const Image<T>& image) {
  check_picture_size(image.width(), image.height());
  if (kind == ".png") return encode_png(image, 0);
  if (kind == ".ppm" || (kind == ".pgm" && !kIsColour<T>)) return encode_netpbm(image);
  if (kind == ".pgm") throw Error("the picture is in colour, a PGM is grey: write a .ppm");
  if (kind == ".tif" || kind == ".tiff") return encode_tiff(image);
  if (kind == ".jpg" || kind == ".jpeg") {
    if constexpr (!kIsSixteenBit<T>) return encode_jpeg(image, kQuality);
    throw Error("the picture has 16 bits, a JPEG 8: write a .png or .tif");
  }
  throw Error("the name of a picture must end in .png, .tif, .tiff, .jpg, .jpeg, .pgm or .ppm");
}

}  // namespace

Image8 read_image(const std::filesystem::path& file) {
  return naming(file, [&] {
    if (const auto frame = frame_of(file))
      return frame_sequence(frame->sequence)->grey(frame->frame);
    return decode_image(read_bytes(file));
  });
}

Image8 decode_image(std::string_view bytes) { return decode_grey8(*image_decoder(bytes)); }

Image8 scaled_to_8_bits(const ImageView16& image) { return scaled_by_brightest(image); }

Picture read_picture(const std::filesystem::path& file) {
  return naming(file, [&]() -> Picture {
    if (const auto frame = frame_of(file))
      return frame_sequence(frame->sequence)->picture(frame->frame);
    const std::string bytes = read_bytes(file);
    return decode_picture(*image_decoder(bytes));
  });
}

Picture read_reduced(const std::filesystem::path& file, int least_width) {
  if (frame_of(file)) return read_picture(file);
  return naming(file, [&] {
    const std::string bytes = read_bytes(file);
    return decode_picture(
        *(is_jpeg(bytes) ? reduced_jpeg_decoder(bytes, least_width) : image_decoder(bytes)));
  });
}

ImageHeader read_image_header(const std::filesystem::path& file) {
  return naming(file, [&]() -> ImageHeader {
    if (const auto frame = frame_of(file)) return {frame_sequence(frame->sequence)->about().size};
    const OpenPicture open(file);
    const HeaderCopy copy(open.descriptor(), open.size());
    const ImageDecoder::Header header = image_decoder(copy.bytes())->header();
    ImageSize size{header.width, header.height};
    if (swaps_sides(header.orientation)) std::swap(size.width, size.height);
    return {size, header.orientation};
  });
}

ImageSize read_image_size(const std::filesystem::path& file) {
  return read_image_header(file).size;
}

bool is_picture_name(const std::filesystem::path& file) {
  const std::string kind = lower_case(file.extension().string());
  return std::ranges::any_of(kPictureKinds, [&](std::string_view known) { return kind == known; });
}

std::vector<std::filesystem::path> list_pictures(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> files;
  std::filesystem::directory_iterator entries(folder, error);
  for (; !error && entries != std::filesystem::directory_iterator(); entries.increment(error))
    if (is_picture_name(entries->path()) && !entries->path().filename().string().starts_with('.'))
      files.push_back(entries->path());
  if (error) throw Error(folder.string() + ": must be a folder of pictures: " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

void write_png(const std::filesystem::path& file, const Image8& image, double pixels_per_inch) {
  write_as_png(file, image, pixels_per_inch);
}

void write_png(const std::filesystem::path& file, const Image16& image) {
  write_as_png(file, image);
}

void write_png(const std::filesystem::path& file, const ImageRgb& image) {
  write_as_png(file, image);
}

void write_png(const std::filesystem::path& file, const ImageRgb16& image) {
  write_as_png(file, image);
}

std::string jpeg_bytes(const Picture& picture, int quality) {
  check_picture_size(size_of(picture).width, size_of(picture).height);
  if (const auto* grey = std::get_if<Image8>(&picture)) return encode_jpeg(*grey, quality);
  if (const auto* colour = std::get_if<ImageRgb>(&picture)) return encode_jpeg(*colour, quality);
  throw Error("the picture has 16 bits, a JPEG 8");
}

void write_picture(const std::filesystem::path& file, const Picture& picture) {
  const std::string kind = lower_case(file.extension().string());
  const auto encode = [&](const auto& image) { return encoded(kind, image); };
  write_whole(file, naming(file, [&] { return std::visit(encode, picture); }));
}

void check_pixel_count(std::int64_t width, std::int64_t height) {
  check_picture_size(width, height);
}

}  // namespace tagcal
