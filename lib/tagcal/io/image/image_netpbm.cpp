#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <string_view>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/io/image/image_codec.hpp"

namespace tagcal::internal {
namespace {

// Netpbm's grey and colour formats: P2 and P3 (decimal text), P5 and P6 (binary, 16-bit values with
// the high byte first).
class NetpbmDecoder : public ImageDecoder {
 public:
  explicit NetpbmDecoder(std::string_view bytes)
      : rest_(bytes.substr(2)), text_(bytes[1] == '2' || bytes[1] == '3') {
    header_.channels = bytes[1] == '3' || bytes[1] == '6' ? 3 : 1;
    header_.width = next_number("the width");
    header_.height = next_number("the height");
    max_value_ = next_number("the largest value");
    if (max_value_ < 1 || max_value_ > 65535) {
      throw Error(fmt::format("the largest value must be 1 to 65535, got {}", max_value_));
    }
    header_.sixteen_bit = max_value_ > 255;
    header_.white = header_.sixteen_bit ? 65535 : max_value_;
    if (!text_) rest_.remove_prefix(std::min<std::size_t>(1, rest_.size()));  // one white space
    check_picture_size(header_.width, header_.height);
    check_length();
  }

  void decode(const RowSink& sink) override {
    std::vector<std::uint16_t> row(num_row_values());
    for (int y = 0; y < header_.height; ++y) {
      for (std::uint16_t& value : row) value = text_ ? next_text_value() : next_binary_value();
      sink(y, row.data());
    }
  }

 private:
  std::size_t num_row_values() const {
    return static_cast<std::size_t>(header_.width) * static_cast<std::size_t>(header_.channels);
  }

  void check_length() const {
    const std::size_t value_bytes = text_ || header_.sixteen_bit ? 2 : 1;  // at least
    const std::size_t left =
        value_bytes * num_row_values() * static_cast<std::size_t>(header_.height);
    if (rest_.size() + (text_ ? 1 : 0) < left) throw Error("is truncated");
  }

  int next_number(const char* what) {
    skip_space();
    int value = 0;
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    if (error != std::errc() || value < 0) {
      throw Error(fmt::format("is not a PGM or PPM picture, or truncated: {} is missing", what));
    }
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return value;
  }

  void skip_space() {
    while (!rest_.empty()) {
      if (rest_.front() == '#') {
        rest_.remove_prefix(std::min(rest_.find('\n'), rest_.size()));
      } else if (std::strchr(" \t\r\n\v\f", rest_.front()) && rest_.front() != '\0') {
        rest_.remove_prefix(1);
      } else {
        return;
      }
    }
  }

  std::uint16_t checked(int value) const {
    if (value > max_value_) {
      throw Error(fmt::format("values must be at most {}, got {}", max_value_, value));
    }
    return static_cast<std::uint16_t>(value);
  }

  std::uint16_t next_text_value() { return checked(next_number("a value")); }

  std::uint16_t next_binary_value() {
    const auto byte = [&] {
      const auto value = static_cast<std::uint8_t>(rest_.front());
      rest_.remove_prefix(1);
      return value;
    };
    const int high = header_.sixteen_bit ? byte() : 0;
    return checked(high * 256 + byte());
  }

  std::string_view rest_;
  bool text_;
  int max_value_ = 0;
};

}  // namespace

std::unique_ptr<ImageDecoder> netpbm_decoder(std::string_view bytes) {
  return std::make_unique<NetpbmDecoder>(bytes);
}

template <typename T>
std::string encode_netpbm(const Image<T>& image) {
  std::string bytes = fmt::format("{}\n{} {}\n{}\n", kIsColour<T> ? "P6" : "P5", image.width(),
                                  image.height(), kIsSixteenBit<T> ? 65535 : 255);
  const std::size_t at = bytes.size();
  const std::size_t size = image.pixels().size() * sizeof(T);
  bytes.resize(at + size);
  std::memcpy(bytes.data() + at, image.pixels().data(), size);
  if constexpr (kIsSixteenBit<T> && std::endian::native == std::endian::little)
    for (std::size_t i = at; i < bytes.size(); i += 2) std::swap(bytes[i], bytes[i + 1]);
  return bytes;
}

template std::string encode_netpbm(const Image8&);
template std::string encode_netpbm(const Image16&);
template std::string encode_netpbm(const ImageRgb&);
template std::string encode_netpbm(const ImageRgb16&);

}  // namespace tagcal::internal
