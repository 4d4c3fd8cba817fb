// Detection on raw pictures of any size and content, for all kinds of boards and options.
#include "fuzz/pictures.hpp"
#include "tagcal/io/image_file.hpp"

namespace {

using namespace tagcal;

// Noise, a pattern of squares, or what remains of the input, as often as needed.
std::uint16_t level(int kind, int x, int y, int period, const std::uint8_t* rest,
                    std::size_t num_rest) {
  const unsigned index = static_cast<unsigned>(y) * 1021U + static_cast<unsigned>(x);
  if (kind == 0 && num_rest > 0) return static_cast<std::uint16_t>(rest[index % num_rest] * 257U);
  if (kind == 1) return (x / period + y / period) % 2 == 0 ? 65535 : 0;
  if (kind == 2 && num_rest > 0) {
    const auto cell = static_cast<unsigned>(y / period * 11 + x / period);
    return rest[cell % num_rest] % 2 == 0 ? 60000 : 4000;
  }
  return static_cast<std::uint16_t>(index * 2654435761U >> 16U);
}

Image8 picture_of(const ImageSize& size, int kind, int period, bool sixteen_bit,
                  const std::uint8_t* rest, std::size_t num_rest) {
  Image16 deep(size);
  Image8 image(size);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      deep(x, y) = level(kind, x, y, period, rest, num_rest);
      image(x, y) = static_cast<std::uint8_t>(deep(x, y) >> 8U);
    }
  }
  return sixteen_bit ? scaled_to_8_bits(deep) : image;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kHeader = 10;
  fuzz::Bytes bytes(data, size);
  const ImageSize image_size{bytes.whole(0, 200), bytes.whole(0, 160)};
  const int kind = bytes.byte() % 4;
  const int period = 1 + bytes.byte() % 40;
  const bool sixteen_bit = bytes.flag();
  const std::vector<PlacedBoard> boards{{fuzz::board_of(bytes.byte() % 5), Pose()}};
  DetectOptions options;
  options.threads = 1;
  options.max_hamming = bytes.byte() % 3;
  options.refinement = static_cast<Refinement>(bytes.byte() % 3);
  const std::uint8_t* rest = size > kHeader ? data + kHeader : nullptr;
  const Image8 image =
      picture_of(image_size, kind, period, sixteen_bit, rest, rest ? size - kHeader : 0);
  const bool is_searched = fuzz::is_accepted(
      [&] { fuzz::check_view(detect(image, boards, options, "picture").view, image_size); });
  fuzz::require(is_searched, "every picture can be searched");
  return 0;
}
