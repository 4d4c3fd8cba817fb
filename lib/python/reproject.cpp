#include "python/reproject.hpp"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>
#include <limits>

#include "python/bindings.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "tagcal/error.hpp"
#include "tagcal/reproject/maps.hpp"
#include "tagcal/reproject/resampling.hpp"

// Pictures and maps of pixels from one camera to another, to a panorama, to a plane.

namespace tagcal::python {
namespace {

using Map = py::array_t<float>;
using NewPicture = std::variant<py::array_t<std::uint8_t>, py::array_t<std::uint16_t>>;
using NewPictureAndMask = std::pair<NewPicture, py::array_t<std::uint8_t>>;

Interpolation interpolation_of(const std::string& name) {
  if (name == "nearest") return Interpolation::nearest;
  if (name == "bilinear") return Interpolation::bilinear;
  if (name == "lanczos4") return Interpolation::lanczos4;
  throw Error("interpolation: must be \"nearest\", \"bilinear\" or \"lanczos4\", got \"" + name +
              "\"");
}

ResampleOptions options_of(const std::string& interpolation, bool area_correct, int threads) {
  check_threads(threads);
  return {interpolation_of(interpolation), area_correct, threads};
}

Reprojection reprojection_of(const Camera& camera, const Target& target, const PoseLike& pose) {
  check_new_picture(size_of(target), "target");
  if (!pose.is_none()) return {camera, target, pose_of(pose, "camera_from_target")};
  if (std::holds_alternative<PlaneRaster>(target))
    throw Error("camera_from_target: must be the pose of the plane's frame, got None");
  return {camera, target, Pose()};
}

// A value of a picture: one whole number of its range, or three for colour.
template <typename Value>
Value level_of(double value) {
  constexpr double kMost = std::numeric_limits<Value>::max();
  if (!(value >= 0 && value <= kMost && value == std::floor(value)))
    throw Error("border: must be whole numbers from 0 to " + number(kMost) + ", got " +
                number(value));
  return static_cast<Value>(value);
}

template <typename T>
T border_of(const ArrayLike& border) {
  if (border.is_none()) return T();
  const py::array_t<double> values = real_array(border, "border");
  if constexpr (std::is_integral_v<T>) {
    if (values.size() != 1) throw Error("border: must be one number for a grey picture");
    return level_of<T>(values.data()[0]);
  } else {
    using Value = typename T::value_type;
    if (values.size() != 1 && values.size() != 3)
      throw Error("border: must be one number, or three for a picture of colour");
    const py::ssize_t step = values.size() == 3 ? 1 : 0;
    const double* v = values.data();
    return {level_of<Value>(v[0]), level_of<Value>(v[step]), level_of<Value>(v[2 * step])};
  }
}

template <typename T>
NewPicture new_picture(const Image<T>& image) {
  if constexpr (std::is_same_v<T, std::uint8_t> || std::is_same_v<T, Rgb>)
    return py::array_t<std::uint8_t>(array_of(image));
  else
    return py::array_t<std::uint16_t>(array_of(image));
}

// `resample(view, border)` for the kind of the picture.
template <typename Resample>
NewPictureAndMask resampled(const AnyPicture& picture, const ArrayLike& border,
                            const Resample& resample) {
  const auto of_kind = [&]<typename T>(const ImageView<T>& view) -> NewPictureAndMask {
    const T value = border_of<T>(border);
    Resampled<T> result;
    {
      py::gil_scoped_release release;
      result = resample(view, value);
    }
    return {new_picture(result.image), py::array_t<std::uint8_t>(array_of(result.seen))};
  };
  return std::visit(of_kind, picture.view());
}

NewPictureAndMask reproject_image(const ArrayLike& image, const Camera& camera,
                                  const Target& target, const PoseLike& pose,
                                  const std::string& interpolation, bool area_correct,
                                  const ArrayLike& border, int threads) {
  const AnyPicture picture(image, "image");
  const Reprojection reprojection = reprojection_of(camera, target, pose);
  const ResampleOptions options = options_of(interpolation, area_correct, threads);
  const ImageSize size = std::visit([](const auto& view) { return view.size(); }, picture.view());
  if (size != camera.image_size)
    throw Error("image: must have the camera's size " + size_text(camera.image_size) + ", got " +
                size_text(size));
  return resampled(picture, border, [&]<typename T>(const ImageView<T>& view, const T& value) {
    return reproject(view, reprojection, options, value);
  });
}

std::pair<Map, Map> map_of(const Camera& camera, const Target& target, const PoseLike& pose,
                           int threads) {
  const Reprojection reprojection = reprojection_of(camera, target, pose);
  check_threads(threads);
  PixelMap map;
  {
    py::gil_scoped_release release;
    map = pixel_map(reprojection, threads);
  }
  return {Map(array_of(map.x)), Map(array_of(map.y))};
}

using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;

FloatArray map_array(const ArrayLike& argument, const char* name) {
  const auto array = py::array::ensure(argument);
  if (!array || argument.is_none() || (array.dtype().kind() != 'f' && array.dtype().kind() != 'i'))
    throw Error(std::string(name) + ": must be an array (height, width) of numbers");
  if (array.ndim() != 2)
    throw Error(std::string(name) + ": must have the shape (height, width), got " +
                shape_text(array));
  constexpr py::ssize_t kMost = 1 << 30;  // numeric: an int holds it
  check_new_picture({static_cast<int>(std::min(array.shape(1), kMost)),
                     static_cast<int>(std::min(array.shape(0), kMost))},
                    name);
  auto floats = FloatArray::ensure(array);
  if (!floats) throw Error(std::string(name) + ": cannot be read as float32");
  return floats;
}

// Where a coordinate is no number, or far outside of any picture, there is no source.
PixelMap map_from(const FloatArray& x, const FloatArray& y) {
  constexpr float kFarthest = 1e8;  // numeric: pictures have at most 1e8 pixels
  const ImageSize size{static_cast<int>(x.shape(1)), static_cast<int>(x.shape(0))};
  PixelMap map{ImageF(size), ImageF(size)};
  const float *from_x = x.data(), *from_y = y.data();
  float *to_x = map.x.row(0), *to_y = map.y.row(0);
  for (py::ssize_t i = 0; i < x.size(); ++i) {
    const bool is_source = std::abs(from_x[i]) <= kFarthest && std::abs(from_y[i]) <= kFarthest;
    to_x[i] = is_source ? from_x[i] : kNoSource;
    to_y[i] = is_source ? from_y[i] : kNoSource;
  }
  return map;
}

NewPictureAndMask remap_image(const ArrayLike& image, const ArrayLike& map_x,
                              const ArrayLike& map_y, const std::string& interpolation,
                              bool area_correct, const ArrayLike& border, int threads) {
  const AnyPicture picture(image, "image");
  const FloatArray x = map_array(map_x, "map_x"), y = map_array(map_y, "map_y");
  if (x.shape(0) != y.shape(0) || x.shape(1) != y.shape(1))
    throw Error("map_y: must have the shape of map_x");
  const ResampleOptions options = options_of(interpolation, area_correct, threads);
  return resampled(picture, border, [&]<typename T>(const ImageView<T>& view, const T& value) {
    return remap(view, map_from(x, y), options, value);
  });
}

}  // namespace

void bind_reproject(py::module_& m) {
  bind_reproject_targets(m);
  m.def("reproject", &reproject_image, py::arg("image"), py::arg("from_"), py::arg("to"),
        py::arg("camera_from_target") = py::none(), py::arg("interpolation") = "bilinear",
        py::arg("area_correct") = true, py::arg("border") = py::none(), py::arg("threads") = 1,
        "The picture of the camera `from_` as `to` shows it: another Camera at the same place, a "
        "Panorama, or a PlaneRaster; and the mask (height, width), uint8, 255 where the pixel's "
        "centre is in the source, 0 where it has the value `border` (one number, or three; 0 by "
        "default).\n"
        "image: (height, width) or (height, width, 3), uint8 or uint16.\n"
        "camera_from_target: a Pose or (4, 4). For a plane: of its frame, needed. Else only its "
        "rotation counts; None: the axes of the camera.\n"
        "interpolation: \"nearest\", \"bilinear\" or \"lanczos4\".\n"
        "area_correct: averages where the target is coarser than the source, so that no detail "
        "is aliased; False: as cv2.remap.\n"
        "threads: 0: one per core; the picture does not depend on it.");
  m.def("pixel_map", &map_of, py::arg("camera"), py::arg("target"),
        py::arg("camera_from_target") = py::none(), py::arg("threads") = 1,
        "For each pixel of the target the pixel of the camera that shows the same: x and y, both "
        "(height, width), float32, as cv2.remap takes them; (-1, -1) where there is none.");
  m.def("remap", &remap_image, py::arg("image"), py::arg("map_x"), py::arg("map_y"),
        py::arg("interpolation") = "bilinear", py::arg("area_correct") = true,
        py::arg("border") = py::none(), py::arg("threads") = 1,
        "The picture whose pixels come from (map_x, map_y) of `image`, as `pixel_map` returns "
        "them, and the mask, as `reproject` does it.");
}

}  // namespace tagcal::python
