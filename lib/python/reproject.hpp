#pragma once

#include <pybind11/pybind11.h>

#include <variant>

#include "python/arrays.hpp"

namespace tagcal::python {

// A picture of any kind, (height, width) or (height, width, 3), uint8 or uint16, in the memory of
// numpy, whose pixels of a row must be contiguous; a copy otherwise. Throws Error with the
// argument's name. Needs the GIL to be made and destroyed, view() does not.
class AnyPicture {
 public:
  using View = std::variant<ImageView8, ImageView16, ImageView<Rgb>, ImageView<Rgb16>>;

  AnyPicture(py::handle argument, const char* name);
  const View& view() const { return view_; }

 private:
  std::variant<std::monostate, py::array, PictureArray<std::uint8_t>, PictureArray<std::uint16_t>,
               Picture>
      owner_;
  View view_;
};

// Throws Error that begins with the name for a side below 1 px and more than 100 megapixels.
void check_new_picture(const ImageSize& size, const char* name);

// A part of bind_reproject: Panorama, PlaneRaster, and the cameras that show what another one sees.
void bind_reproject_targets(pybind11::module_& m);

}  // namespace tagcal::python
