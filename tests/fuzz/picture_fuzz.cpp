// Pictures of all kinds. The functions that read them agree, and what was read is written.
#include "fuzz/fuzz.hpp"
#include "tagcal/io/image_file.hpp"

namespace {

using namespace tagcal;

// A copy without loss is the same.
void check_copy(const std::filesystem::path& file, const Picture& picture) {
  Picture copy;
  const bool is_written = fuzz::is_accepted([&] {
    write_picture(file, picture);
    copy = read_picture(file);
  });
  fuzz::require(is_written, "a picture that was read can be written and read again");
  const bool is_same = std::visit(
      [&](const auto& image) {
        const auto* const same = std::get_if<std::decay_t<decltype(image)>>(&copy);
        return same != nullptr && same->size() == image.size() && same->pixels() == image.pixels();
      },
      picture);
  fuzz::require(is_same, "and is the same");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Scratch scratch;
  const std::filesystem::path file = scratch.write("picture", fuzz::text_of(data, size));
  ImageSize of_header;
  if (!fuzz::is_accepted([&] { of_header = read_image_size(file); })) return 0;
  fuzz::require(of_header.width > 0 && of_header.height > 0, "a picture has pixels");
  if (std::int64_t{of_header.width} * of_header.height > 4'000'000) return 0;  // takes long

  Picture picture;
  const bool is_read = fuzz::is_accepted([&] { picture = read_picture(file); });
  Image8 grey;
  const bool is_grey = fuzz::is_accepted([&] { grey = read_image(file); });
  fuzz::require(is_read == is_grey, "grey and colour are read or refused alike");
  if (is_read) fuzz::require(size_of(picture) == of_header, "the size is that of the header");
  if (is_grey) fuzz::require(grey.size() == of_header, "so is that in grey");
  fuzz::is_accepted([&] {
    const Picture small = read_reduced(file, 16);
    fuzz::require(size_of(small).width <= of_header.width, "a reduced picture is no larger");
  });
  if (!is_read || of_header.width > 2000) return 0;

  check_copy(scratch.folder() / "copy.png", picture);
  check_copy(scratch.folder() / "copy.tif", picture);
  const bool is_colour =
      std::holds_alternative<ImageRgb>(picture) || std::holds_alternative<ImageRgb16>(picture);
  check_copy(scratch.folder() / (is_colour ? "copy.ppm" : "copy.pgm"), picture);
  fuzz::is_accepted([&] {  // one of 16 bits is refused
    const auto jpeg = jpeg_bytes(picture, 90);
    const auto copy = read_picture(scratch.write("copy.jpg", jpeg));
    fuzz::require(size_of(copy) == of_header, "a copy has the same size");
  });
  return 0;
}
