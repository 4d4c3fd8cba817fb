#pragma once

#include <gtest/gtest.h>
#include <png.h>

#include <filesystem>
#include <vector>

#include "tagcal/scene/image.hpp"

namespace tagcal {

// The colours that a PNG in colour holds, by libpng's own simple interface.
inline std::vector<Rgb> png_colours(const std::filesystem::path& file) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_file(&png, file.c_str()), 0) << png.message;
  EXPECT_EQ(png.format, static_cast<png_uint_32>(PNG_FORMAT_RGB));  // as stored
  std::vector<Rgb> colours(static_cast<std::size_t>(png.width) * png.height);
  EXPECT_NE(png_image_finish_read(&png, nullptr, colours.data(), 0, nullptr), 0) << png.message;
  return colours;
}

}  // namespace tagcal
