#include "python/reproject.hpp"

#include <algorithm>

#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::python {
namespace {

// Colour in the memory of numpy: three values a pixel, whole pixels a row.
template <typename T>
bool is_in_place(const py::array& array) {
  using Value = typename T::value_type;
  constexpr py::ssize_t kBytes = sizeof(T);
  return has_type<Value>(array) && array.strides(2) == sizeof(Value) &&
         array.strides(1) == kBytes && array.strides(0) >= kBytes * array.shape(1) &&
         array.strides(0) % kBytes == 0 &&
         reinterpret_cast<std::uintptr_t>(array.data()) % alignof(Value) == 0;
}

template <typename T>
ImageView<T> view_of(const py::array& array) {
  return {static_cast<const T*>(array.data()),
          {static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0))},
          array.strides(0) / static_cast<py::ssize_t>(sizeof(T))};
}

}  // namespace

AnyPicture::AnyPicture(py::handle argument, const char* name) {
  if (py::isinstance<py::array>(argument)) {
    const auto array = py::reinterpret_borrow<py::array>(argument);
    if (array.ndim() == 2 && has_type<std::uint8_t>(array)) {
      view_ = owner_.emplace<PictureArray<std::uint8_t>>(argument, name).view();
      return;
    }
    if (array.ndim() == 2 && has_type<std::uint16_t>(array)) {
      view_ = owner_.emplace<PictureArray<std::uint16_t>>(argument, name).view();
      return;
    }
    if (array.ndim() == 3 && array.shape(2) == 3 && array.size() > 0 &&
        (is_in_place<Rgb>(array) || is_in_place<Rgb16>(array))) {
      check_new_picture({static_cast<int>(std::min<py::ssize_t>(array.shape(1), 1 << 30)),
                         static_cast<int>(std::min<py::ssize_t>(array.shape(0), 1 << 30))},
                        name);
      if (is_in_place<Rgb>(array))
        view_ = view_of<Rgb>(array);
      else
        view_ = view_of<Rgb16>(array);
      owner_ = array;
      return;
    }
  }
  const Picture& copy = owner_.emplace<Picture>(picture_of(argument, name));
  std::visit([this]<typename T>(const Image<T>& image) { view_ = ImageView<T>(image); }, copy);
}

void check_new_picture(const ImageSize& size, const char* name) {
  try {
    check_pixel_count(size.width, size.height);
  } catch (const Error& error) {
    throw Error(std::string(name) + ": " + error.what());
  }
}

}  // namespace tagcal::python
