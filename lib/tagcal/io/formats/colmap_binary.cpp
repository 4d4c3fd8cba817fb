#include "tagcal/io/formats/colmap.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <iterator>
#include <string_view>

#include "tagcal/error.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/text/limits.hpp"

namespace tagcal::internal {
namespace {

// COLMAP's models by their numbers (src/colmap/sensor/models.h).
struct NumberedModel {
  std::string_view name;
  int num_parameters;
};
constexpr NumberedModel kModels[] = {{"SIMPLE_PINHOLE", 3},
                                     {"PINHOLE", 4},
                                     {"SIMPLE_RADIAL", 4},
                                     {"RADIAL", 5},
                                     {"OPENCV", 8},
                                     {"OPENCV_FISHEYE", 8},
                                     {"FULL_OPENCV", 12},
                                     {"FOV", 5},
                                     {"SIMPLE_RADIAL_FISHEYE", 4},
                                     {"RADIAL_FISHEYE", 5},
                                     {"THIN_PRISM_FISHEYE", 12}};

// Little-endian values, one after the other.
class BinaryReader {
 public:
  BinaryReader(std::string_view bytes, const std::string& file) : rest_(bytes), file_(file) {}

  template <typename Value>
  Value next() {
    Value value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }

  // A number of cameras, pictures or points. Each takes at least `bytes`.
  std::size_t count(std::size_t bytes) {
    const auto count = next<std::uint64_t>();
    if (count > rest_.size() / bytes) fail("is truncated, or no binary file of COLMAP");
    return static_cast<std::size_t>(count);
  }

  std::string_view name() {
    const std::size_t end = rest_.find('\0');
    if (end == std::string_view::npos) fail("is truncated");
    return take(end + 1).substr(0, end);
  }

  std::string_view take(std::size_t size) {
    if (size > rest_.size()) fail("is truncated, or no binary file of COLMAP");
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }

  [[noreturn]] void fail(const std::string& message) const { throw Error(file_ + ": " + message); }

 private:
  std::string_view rest_;
  const std::string& file_;
};

}  // namespace

std::string colmap_cameras_text(const std::string& bytes, const std::string& file) {
  BinaryReader in(bytes, file);
  std::string text;
  for (std::size_t left = in.count(24); left > 0; --left) {
    const auto id = in.next<std::uint32_t>();
    const auto model = in.next<std::int32_t>();
    const auto width = in.next<std::uint64_t>(), height = in.next<std::uint64_t>();
    if (model < 0 || model >= std::ssize(kModels))
      in.fail(fmt::format("camera {}: has no model that COLMAP had, but number {}", id, model));
    text += fmt::format("{} {} {} {}", id, kModels[model].name, width, height);
    for (int i = 0; i < kModels[model].num_parameters; ++i)
      text.append(" ").append(dotted_number(in.next<double>()));
    text += "\n";
  }
  return text;
}

std::string colmap_images_text(const std::string& bytes, const std::string& file) {
  constexpr std::size_t kPoint = 24;  // bytes of two coordinates and a number
  BinaryReader in(bytes, file);
  std::string text;
  for (std::size_t left = in.count(64); left > 0; --left) {
    text += std::to_string(in.next<std::uint32_t>());
    for (int i = 0; i < 7; ++i) text.append(" ").append(dotted_number(in.next<double>()));
    text += fmt::format(" {} ", in.next<std::uint32_t>());
    text += std::string(in.name()) + "\n\n";
    in.take(kPoint * in.count(kPoint));
  }
  return text;
}

}  // namespace tagcal::internal
