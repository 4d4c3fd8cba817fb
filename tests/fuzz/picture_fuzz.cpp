// Pictures of all kinds. The functions that read them agree, and what was read is written.
#include "fuzz/fuzz.hpp"
#include "tagcal/io/image_file.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tagcal;
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

  const std::filesystem::path copy = scratch.folder() / "copy.png";
  const bool is_written = fuzz::is_accepted([&] {
    write_picture(copy, picture);
    fuzz::require(size_of(read_picture(copy)) == of_header, "a copy has the same size");
  });
  fuzz::require(is_written, "a picture that was read can be written and read again");
  return 0;
}
