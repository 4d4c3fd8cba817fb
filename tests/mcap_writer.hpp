#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "tagcal/scene/image.hpp"

namespace tagcal {

// An MCAP file of pictures, written independently of the reader (https://mcap.dev/spec).
class McapWriter {
 public:
  explicit McapWriter(const std::string& topic) {
    bytes_ = std::string("\x89MCAP0\r\n", 8);
    record(1, text("ros2") + text("tests"));
    record(3, number<2>(1) + text("sensor_msgs/msg/Image") + text("ros2msg") + text("# Image"));
    record(4, number<2>(7) + number<2>(1) + text(topic) + text("cdr") + number<4>(0));
  }

  // A mono8 picture in CDR of the given order of bytes.
  static std::string message(const Image8& image, double time_s, bool big_endian = false) {
    const auto whole = [&](std::uint64_t value) {
      std::string bytes = number<4>(value);
      return big_endian ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
    };
    const auto seconds = static_cast<std::uint64_t>(time_s);
    std::string body =
        whole(seconds) +
        whole(static_cast<std::uint64_t>(1e9 * (time_s - static_cast<double>(seconds)) + 0.5)) +
        whole(4) + std::string("cam\0", 4) + whole(image.height()) + whole(image.width()) +
        whole(6) + std::string("mono8\0", 6) + '\0';
    body.resize((body.size() + 3) / 4 * 4);
    body +=
        whole(image.width()) + whole(static_cast<std::uint64_t>(image.width()) * image.height());
    for (int y = 0; y < image.height(); ++y)
      body.append(reinterpret_cast<const char*>(image.row(y)), image.width());
    return std::string("\0", 1) + (big_endian ? '\0' : '\1') + std::string("\0\0", 2) + body;
  }

  void add(const std::string& message) {
    record(5, number<2>(7) + number<4>(0) + number<8>(1) + number<8>(1) + message);
  }

  // A chunk whose records are said to have `size` bytes.
  void add_chunk(const std::string& compression, const std::string& stored, std::uint64_t size) {
    record(6, number<8>(0) + number<8>(0) + number<8>(size) + number<4>(0) + text(compression) +
                  number<8>(stored.size()) + stored);
  }

  std::string bytes() {
    record(2, number<8>(0) + number<8>(0) + number<4>(0));
    return bytes_ + std::string("\x89MCAP0\r\n", 8);
  }

 private:
  template <int kBytes>
  static std::string number(std::uint64_t value) {
    std::string bytes;
    for (int i = 0; i < kBytes; ++i) bytes += static_cast<char>(value >> 8 * i);
    return bytes;
  }
  static std::string text(const std::string& text) { return number<4>(text.size()) + text; }
  void record(int op, const std::string& data) {
    bytes_ += static_cast<char>(op) + number<8>(data.size()) + data;
  }

  std::string bytes_;
};

}  // namespace tagcal
