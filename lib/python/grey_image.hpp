#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <optional>
#include <variant>

#include "python/arrays.hpp"
#include "tagcal/detect/types.hpp"

namespace tagcal::python {

// A picture: an array (height, width) of uint8 or uint16, or (height, width, 3 or 4) of colours in
// any order, or the path of a file.
using ImageLike = Argument<"ImageLike">;

// A picture to be searched, of 8 bits: an array of uint8 in place; one of uint16 as read_image
// scales it; colours as grey; the path of a file as read_image reads it. Throws Error with the
// argument's name for anything else.
class GreyImage {
 public:
  // Needs the GIL, as the destructor does.
  GreyImage(const ImageLike& argument, const std::string& name);

  // Reads or scales the picture if that is needed. The calls below need no GIL.
  void load();
  const ImageView8& view() const { return view_; }  // after load()

  // The picture with its 16 bits; null unless it is an array of uint16. Needs no load().
  const ImageView16* wide_view() const;

  // For a batch; must not outlive this object, and needs no load().
  ImageSource source(const std::string& name) const;

  // The name of the file; empty for an array.
  std::string file_name() const;

 private:
  Image8 loaded() const;

  std::variant<std::filesystem::path, PictureArray<std::uint8_t>, PictureArray<std::uint16_t>>
      input_;
  Image8 image_;
  ImageView8 view_;
};

}  // namespace tagcal::python
