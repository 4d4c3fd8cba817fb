#include "tagcal/io/formats/colmap.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

// A lens of COLMAP: where each of its parameters stands in those of the lens here, -1 for f, which
// is fx and fy.
struct CameraModel {
  std::string_view name;
  bool fisheye;
  std::vector<int> places;
};

const std::vector<CameraModel>& camera_models() {
  static const std::vector<CameraModel> all = {
      {"SIMPLE_PINHOLE", false, {-1, 2, 3}},
      {"PINHOLE", false, {0, 1, 2, 3}},
      {"SIMPLE_RADIAL", false, {-1, 2, 3, 4}},
      {"RADIAL", false, {-1, 2, 3, 4, 5}},
      {"OPENCV", false, {0, 1, 2, 3, 4, 5, 6, 7}},
      {"FULL_OPENCV", false, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}},
      {"SIMPLE_RADIAL_FISHEYE", true, {-1, 2, 3, 4}},
      {"RADIAL_FISHEYE", true, {-1, 2, 3, 4, 5}},
      {"OPENCV_FISHEYE", true, {0, 1, 2, 3, 4, 5, 6, 7}}};
  return all;
}

}  // namespace

Lens colmap_lens(const std::string& name, std::span<const double> values,
                 const std::string& where) {
  const auto kind = std::ranges::find(camera_models(), name, &CameraModel::name);
  if (kind == camera_models().end())
    throw Error(
        fmt::format("{}: MODEL: the lens {} is one that tagcal does not have", where, shown(name)));
  if (values.size() != kind->places.size())
    throw Error(fmt::format("{}: PARAMS: must have {} values with {}, got {}", where,
                            kind->places.size(), name, values.size()));
  std::vector<double> p(12);
  for (std::size_t i = 0; i < kind->places.size(); ++i) {
    if (kind->places[i] < 0) p[0] = p[1] = values[i];
    if (kind->places[i] >= 0) p[static_cast<std::size_t>(kind->places[i])] = values[i];
  }
  p[2] -= kHalfPixel;
  p[3] -= kHalfPixel;
  if (kind->fisheye) p.resize(8);
  return kind->fisheye ? lens_of(kind_of<Fisheye>(), p, where)
                       : lens_of(kind_of<Perspective>(), p, where);
}

ColmapLens lens_of_colmap(const FileCamera& camera) {
  const bool fisheye = is_fisheye(camera);
  const std::span<const double> given =
      fisheye ? parameters(camera.calibration.camera.lens) : perspective_numbers(camera, "colmap");
  std::vector<double> p(given.begin(), given.end());
  const auto zero_from = [&](int first) {
    return std::all_of(p.begin() + first, p.end(), [](double k) { return k == 0; });
  };
  const std::string_view name = fisheye        ? "OPENCV_FISHEYE"
                                : zero_from(4) ? "PINHOLE"
                                : zero_from(8) ? "OPENCV"
                                               : "FULL_OPENCV";
  p.resize(std::ranges::find(camera_models(), name, &CameraModel::name)->places.size());
  p[2] += kHalfPixel;
  p[3] += kHalfPixel;
  return {name, p};
}

}  // namespace tagcal::internal
