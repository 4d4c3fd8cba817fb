#include "python/grey_image.hpp"

#include <pybind11/pybind11.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>

#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::python {
namespace {

using Input =
    std::variant<std::filesystem::path, PictureArray<std::uint8_t>, PictureArray<std::uint16_t>>;

// Grey of colour. Red and blue weigh the same, as OpenCV's order is BGR and others' RGB; a fourth
// channel is left out.
template <typename T>
py::array_t<T> grey_of(const py::array& colour) {
  const auto values = py::array_t<T>::ensure(colour);
  const auto in = values.template unchecked<3>();
  py::array_t<T> grey({colour.shape(0), colour.shape(1)});
  auto out = grey.template mutable_unchecked<2>();
  constexpr double kGreen = 0.587;  // numeric: ITU-R BT.601; (0.299 + 0.114) / 2 for the others
  for (py::ssize_t y = 0; y < in.shape(0); ++y)
    for (py::ssize_t x = 0; x < in.shape(1); ++x)
      out(y, x) = static_cast<T>((1 - kGreen) / 2 * (in(y, x, 0) + in(y, x, 2)) +
                                 kGreen * in(y, x, 1) + 0.5);
  return grey;
}

bool has_colour(const py::array& array) {
  return array.ndim() == 3 && (array.shape(2) == 3 || array.shape(2) == 4);
}

template <typename T>
PictureArray<T> grey_array(const py::array& array, const char* name) {
  if (has_colour(array)) return {grey_of<T>(array), name};
  return {array, name};
}

Input input_of(const ImageLike& argument, const std::string& name) {
  if (py::isinstance<py::str>(argument) || py::hasattr(argument, "__fspath__")) {
    py::detail::make_caster<std::filesystem::path> path;
    if (path.load(argument, true)) return py::detail::cast_op<std::filesystem::path>(path);
    throw Error(name + ": is no path of a file");
  }
  if (!py::isinstance<py::array>(argument))
    throw Error(name + ": must be an array (height, width) or the path of a file, got " +
                type_name(argument));
  const auto array = py::reinterpret_borrow<py::array>(argument);
  const py::dtype type = array.dtype();
  if (type.kind() == 'u' && type.itemsize() == 2)
    return grey_array<std::uint16_t>(array, name.c_str());
  if (type.kind() != 'u' || type.itemsize() != 1)
    throw Error(name + ": must be uint8 or uint16, got " +
                py::cast<std::string>(type.attr("__str__")()) +
                "; convert it, for example with (255 * image).astype(np.uint8)");
  return grey_array<std::uint8_t>(array, name.c_str());
}

Image8 copy_of(const ImageView8& view) {
  Image8 image(view.size());
  for (int y = 0; y < view.height(); ++y) std::copy_n(view.row(y), view.width(), image.row(y));
  return image;
}

}  // namespace

GreyImage::GreyImage(const ImageLike& argument, const std::string& name)
    : input_(input_of(argument, name)) {}

Image8 GreyImage::loaded() const {
  if (const auto* file = std::get_if<std::filesystem::path>(&input_)) return read_image(*file);
  if (const ImageView16* wide = wide_view()) return scaled_to_8_bits(*wide);
  return copy_of(std::get<PictureArray<std::uint8_t>>(input_).view());
}

void GreyImage::load() {
  if (const auto* array = std::get_if<PictureArray<std::uint8_t>>(&input_)) {
    view_ = array->view();
    return;
  }
  image_ = loaded();
  view_ = image_;
}

const ImageView16* GreyImage::wide_view() const {
  const auto* array = std::get_if<PictureArray<std::uint16_t>>(&input_);
  return array ? &array->view() : nullptr;
}

ImageSource GreyImage::source(const std::string& name) const {
  return {name, [this] { return loaded(); }};
}

std::string GreyImage::file_name() const {
  const auto* file = std::get_if<std::filesystem::path>(&input_);
  return file ? file->filename().string() : "";
}

}  // namespace tagcal::python
