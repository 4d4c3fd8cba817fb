#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>

#include "python/camera.hpp"
#include "python/records.hpp"
#include "python/reproject.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/reproject/cameras.hpp"

// What pictures are reprojected to: cameras, panoramas, planes.

namespace tagcal::python {
namespace {

using Width = std::pair<int, int>;

PanoramaKind panorama_kind(const std::string& name) {
  if (name == "equirectangular") return PanoramaKind::equirectangular;
  if (name == "cylindrical") return PanoramaKind::cylindrical;
  if (name == "transverse") return PanoramaKind::transverse;
  throw Error("kind: must be \"equirectangular\", \"cylindrical\" or \"transverse\", got \"" +
              name + "\"");
}

std::string kind_name(const Panorama& panorama) {
  if (panorama.kind == PanoramaKind::transverse) return "transverse";
  return panorama.kind == PanoramaKind::equirectangular ? "equirectangular" : "cylindrical";
}

Panorama make_panorama(const std::string& kind, double px_per_rad, const ArrayLike& centre,
                       const ArrayLike& size) {
  return {panorama_kind(kind), positive(px_per_rad, "px_per_rad"), vector2(centre, "centre"),
          size_of_argument(size, "size")};
}

PlaneRaster make_plane(const ArrayLike& upper_left, double m_per_px, const ArrayLike& size) {
  return {vector2(upper_left, "upper_left"), positive(m_per_px, "m_per_px"),
          size_of_argument(size, "size")};
}

// The border of the camera's picture is followed pixel by pixel.
void check_outline(const Camera& camera) {
  constexpr int kLongest = 1 << 16;  // numeric: a side; longer ones take seconds
  check_new_picture(camera.image_size, "camera");
  if (std::max(camera.image_size.width, camera.image_size.height) > kLongest)
    throw Error("camera: its picture must have sides up to " + std::to_string(kLongest) +
                " px, got " + std::to_string(camera.image_size.width) + "x" +
                std::to_string(camera.image_size.height));
}

ImageSize new_size(const Camera& camera, const ArrayLike& size) {
  return size.is_none() ? camera.image_size : size_of_argument(size, "size");
}

Camera all_pixels(const Camera& camera, const ArrayLike& size) {
  check_outline(camera);
  const ImageSize image_size = new_size(camera, size);
  py::gil_scoped_release release;
  return pinhole_of_all_pixels(camera, image_size);
}

Camera valid_pixels(const Camera& camera, const ArrayLike& size) {
  check_outline(camera);
  const ImageSize image_size = new_size(camera, size);
  py::gil_scoped_release release;
  return pinhole_of_valid_pixels(camera, image_size);
}

Camera with_focal_length(const Camera& camera, double focal_px, const ArrayLike& size) {
  return pinhole_of_focal_length(camera, positive(focal_px, "focal_px"), new_size(camera, size));
}

std::vector<TurnedCamera> several(const Camera& camera, int count) {
  constexpr int kMost = 360;  // numeric: one a degree
  check_outline(camera);
  if (count < 2 || count > kMost)
    throw Error("count: must be 2 to " + std::to_string(kMost) + ", got " + std::to_string(count));
  constexpr double kLargest = 1e8;  // numeric: a side of 100 megapixels
  const auto p = parameters(camera.lens);
  if (!(p[0] <= kLargest && p[1] <= kLargest))
    throw Error("camera: its focal length must be at most 1e8 px, got " + number(p[0]) + " and " +
                number(p[1]));
  py::gil_scoped_release release;
  return several_pinholes(camera, count);
}

Panorama panorama_for(const Camera& camera, const std::string& kind,
                      const std::optional<double>& px_per_rad) {
  check_outline(camera);
  const PanoramaKind known = panorama_kind(kind);
  const double scale = px_per_rad ? positive(*px_per_rad, "px_per_rad") : 0;
  py::gil_scoped_release release;
  return panorama_of(camera, known, scale);
}

AngularRange range_of(const Camera& camera) {
  check_outline(camera);
  py::gil_scoped_release release;
  return angular_range(camera);
}

std::string degrees(double angle_rad) { return number(internal::degrees(angle_rad), 4); }

void bind_panorama(py::module_& m) {
  Record<Panorama>(m, "Panorama",
                   "A picture of all directions about the vertical axis (y) of its frame, which "
                   "has the axes of a camera. Column u is the longitude (u - centre[0]) / "
                   "px_per_rad, positive to the right of z; row v is centre[1] + px_per_rad * "
                   "latitude (\"equirectangular\") or tan(latitude) (\"cylindrical\"), positive "
                   "downwards.")
      .field("kind", &kind_name,
             "\"equirectangular\", \"cylindrical\", or \"transverse\": equirectangular about the x "
             "axis, "
             "with rows and columns exchanged.")
      .field("px_per_rad", &Panorama::px_per_rad, "Pixels per radian of its middle.")
      .field("centre", &Panorama::centre, "(2,): the pixel of the direction z.")
      .field(
          "size", [](const Panorama& p) { return Width(p.size.width, p.size.height); },
          "(width, height).")
      .representation([](const Panorama& p) {
        return kind_name(p) + " " + size_text(p.size) + ", " + number(p.px_per_rad, 4) +
               " px per radian";
      })
      .def(py::init(&make_panorama), py::arg("kind"), py::arg("px_per_rad"), py::arg("centre"),
           py::arg("size"),
           "`centre`: the pixel (2,) that shows the direction z. `size`: (width, height). See "
           "`panorama_of` for the one of all that a camera sees.");
}

void bind_plane(py::module_& m) {
  Record<PlaneRaster>(m, "PlaneRaster",
                      "A rectangle of the plane z = 0 of a frame (that of a board: x right, y up), "
                      "seen from the side of +z. Pixel (u, v) is the point upper_left + (u, -v) * "
                      "m_per_px.")
      .field("upper_left", &PlaneRaster::upper_left, "(2,): the centre of pixel (0, 0), metres.")
      .field("m_per_px", &PlaneRaster::m_per_px, "Metres per pixel.")
      .field(
          "size", [](const PlaneRaster& p) { return Width(p.size.width, p.size.height); },
          "(width, height).")
      .representation([](const PlaneRaster& p) {
        return size_text(p.size) + ", " + number(p.m_per_px, 4) + " m per pixel";
      })
      .def(py::init(&make_plane), py::arg("upper_left"), py::arg("m_per_px"), py::arg("size"),
           "`upper_left`: (2,), metres, the centre of pixel (0, 0). `size`: (width, height).");
}

void bind_records(py::module_& m) {
  Record<AngularRange>(m, "AngularRange", "The angles of the rays of a picture, radians.")
      .field("left_rad", &AngularRange::left_rad, "The least longitude.")
      .field("right_rad", &AngularRange::right_rad, "The largest longitude.")
      .field("top_rad", &AngularRange::top_rad, "The least latitude (up is negative).")
      .field("bottom_rad", &AngularRange::bottom_rad, "The largest latitude.")
      .field("from_axis_rad", &AngularRange::from_axis_rad,
             "The largest angle from the optical axis.")
      .representation([](const AngularRange& r) {
        return degrees(r.right_rad - r.left_rad) + " x " + degrees(r.bottom_rad - r.top_rad) +
               " degrees, up to " + degrees(r.from_axis_rad) + " from the axis";
      });
  Record<TurnedCamera>(m, "TurnedCamera", "A camera at the place of another one, turned.")
      .field("name", &TurnedCamera::name,
             "\"front\", \"left\", .. of a cube; \"1\" .. of a fan, from the left.")
      .field("camera", &TurnedCamera::camera, "The pinhole.")
      .field("camera_from_turned", &TurnedCamera::camera_from_turned,
             "The rotation from its frame to that of the original camera, for `reproject`.")
      .representation([](const TurnedCamera& t) {
        return "\"" + t.name + "\" " + size_text(t.camera.image_size);
      });
}

}  // namespace

void bind_reproject_targets(py::module_& m) {
  bind_panorama(m);
  bind_plane(m);
  bind_records(m);
  m.def("pinhole_of_all_pixels", &all_pixels, py::arg("camera"), py::arg("size") = py::none(),
        "The pinhole with the longest focal length that shows every pixel of the camera. `size`: "
        "(width, height) of its picture, by default the camera's. cv2.getOptimalNewCameraMatrix "
        "with alpha 1 means the same. Raises Error for rays more than 80 degrees from the axis.");
  m.def("pinhole_of_valid_pixels", &valid_pixels, py::arg("camera"), py::arg("size") = py::none(),
        "The pinhole with the shortest focal length whose picture has no empty pixel (alpha 0).");
  m.def("pinhole_of_focal_length", &with_focal_length, py::arg("camera"), py::arg("focal_px"),
        py::arg("size") = py::none(),
        "The pinhole with fx = focal_px, and its axis at the same place of the picture.");
  m.def("several_pinholes", &several, py::arg("camera"), py::arg("count"),
        "Pinholes that show the field of view together: 5 or 6 are faces of a cube, other numbers "
        "a fan about the vertical axis.");
  m.def("panorama_of", &panorama_for, py::arg("camera"), py::arg("kind") = "equirectangular",
        py::arg("px_per_rad") = py::none(),
        "The panorama of all that the camera sees; a \"cylindrical\" one shows latitudes up to 60 "
        "degrees. `px_per_rad`: by default the camera's fx.");
  m.def("angular_range", &range_of, py::arg("camera"), "The angles of the rays of its picture.");
}

}  // namespace tagcal::python
