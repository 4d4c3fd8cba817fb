#include "python/scene_parts.hpp"

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>
#include <variant>

#include "python/arrays.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/scene_file.hpp"

namespace tagcal::python {

double level(double value, const char* name) {
  if (!(value >= 0 && value <= 1))
    throw Error(std::string(name) + ": must be in 0..1, a share of full white, got " +
                number(value));
  return value;
}

namespace {

constexpr double kMostBlurPx = 100;  // as in scene files

Vignetting vignetting_of(const std::variant<std::string, std::vector<double>>& argument) {
  Vignetting vignetting;
  if (const auto* name = std::get_if<std::string>(&argument)) {
    if (*name != "cos4" && !name->empty())
      throw Error("vignetting: must be cos4 or a list of coefficients, got \"" + *name + "\"");
    vignetting.cos4 = *name == "cos4";
    return vignetting;
  }
  vignetting.polynomial = std::get<std::vector<double>>(argument);
  if (vignetting.polynomial.size() > scene_limits().vignetting_terms)
    throw Error("vignetting: must have at most " + std::to_string(scene_limits().vignetting_terms) +
                " coefficients, got " + std::to_string(vignetting.polynomial.size()));
  for (const double a : vignetting.polynomial)
    if (!std::isfinite(a)) throw Error("vignetting: must be finite, got " + number(a));
  return vignetting;
}

std::optional<Focus> focus_of(const std::optional<double>& distance_m, double aperture_m) {
  not_negative(aperture_m, "aperture_m");
  if (distance_m) return Focus{positive(*distance_m, "focus_distance_m"), aperture_m};
  if (aperture_m > 0) throw Error("aperture_m: needs a focus_distance_m");
  return std::nullopt;
}

Sensor sensor_of(double exposure, double blur_px, double noise_levels, int bits, double gamma,
                 const std::variant<std::string, std::vector<double>>& vignetting,
                 const std::optional<double>& focus_distance_m, double aperture_m,
                 const std::optional<Mosaic>& mosaic, const std::optional<Denoise>& denoise,
                 const std::optional<Sharpen>& sharpen, const std::optional<int>& jpeg) {
  if (not_negative(blur_px, "blur_px") > kMostBlurPx)
    throw Error("blur_px: must be at most " + number(kMostBlurPx) + ", got " + number(blur_px));
  if (bits != 8 && bits != 16) throw Error("bits: must be 8 or 16, got " + std::to_string(bits));
  Sensor sensor;
  sensor.exposure = positive(exposure, "exposure");
  sensor.blur_px = blur_px;
  sensor.noise_levels = not_negative(noise_levels, "noise_levels");
  sensor.bits = bits;
  sensor.gamma = positive(gamma, "gamma");
  sensor.vignetting = vignetting_of(vignetting);
  sensor.focus = focus_of(focus_distance_m, aperture_m);
  sensor.mosaic = mosaic;
  sensor.denoise = denoise;
  sensor.sharpen = sharpen;
  sensor.jpeg = jpeg;
  return sensor;
}

Occluder occluder_of(const ArrayLike& corners, double grey) {
  const Rows3 rows(corners, "corners");
  if (rows.size() < 3 || rows.size() > scene_limits().polygon_corners)
    throw Error("corners: must have 3 to " + std::to_string(scene_limits().polygon_corners) +
                " rows, got " + std::to_string(rows.size()));
  if (const auto wrong = occluder_defect(rows.span())) throw Error("corners: " + *wrong);
  return {{rows.span().begin(), rows.span().end()}, level(grey, "level")};
}

std::vector<Occluder> cuboid_of(const ArrayLike& size_m, const PoseLike& world_from_cuboid,
                                double grey) {
  const Pose pose = pose_of(world_from_cuboid, "world_from_cuboid");
  std::vector<Occluder> faces = cuboid(vector3(size_m, "size_m"), level(grey, "level"));
  for (Occluder& face : faces) {
    face.name = "cuboid";
    for (Eigen::Vector3d& corner : face.corners) corner = pose * corner;
    if (const auto wrong = occluder_defect(face.corners))
      throw Error("size_m: the corners of a face " + *wrong);
  }
  return faces;
}

DirectionalLamp directional_lamp(const ArrayLike& direction, double strength) {
  const DirectionalLamp lamp{vector3(direction, "direction"), not_negative(strength, "strength")};
  if (!(lamp.direction.norm() > 0) || !std::isfinite(lamp.direction.norm()))
    throw Error("direction: must not be zero");
  return lamp;
}

PointLamp point_lamp(const ArrayLike& position, double strength) {
  return {vector3(position, "position"), not_negative(strength, "strength")};
}

using Lamp = std::variant<std::monostate, DirectionalLamp, PointLamp>;

void bind_processing(py::module_& m) {
  Record<Mosaic>(m, "Mosaic", "Colour filters over the pixels of a grey scene.")
      .field("pattern", &Mosaic::pattern, "Upper-left 2 x 2 pixels: RGGB, BGGR, GRBG or GBRG.")
      .field("gains", &Mosaic::gains, "Of red, green and blue.")
      .field("demosaic", &Mosaic::demosaic, "False: a raw mosaic.")
      .representation(
          [](const Mosaic& mosaic) { return mosaic.pattern + (mosaic.demosaic ? "" : ", raw"); })
      .def(py::init(
               [](const std::string& pattern, const std::array<double, 3>& gains, bool demosaic) {
                 return Mosaic{pattern, gains, demosaic};
               }),
           py::arg("pattern") = "RGGB", py::arg("gains") = std::array<double, 3>{1, 1, 1},
           py::arg("demosaic") = true,
           "The light is multiplied by the `gains` of the filters before noise. Unless the mosaic "
           "stays raw, they are divided out, colours are interpolated bilinearly, and the picture "
           "is 0.299 red + 0.587 green + 0.114 blue.");
  Record<Denoise>(m, "Denoise", "Smoothing that keeps edges: the bilateral filter.")
      .field("levels", &Denoise::levels, "Standard deviation in level, of an 8-bit picture.")
      .field("radius_px", &Denoise::radius_px, "Standard deviation of the distance, px.")
      .representation([](const Denoise& denoise) {
        return number(denoise.levels) + " levels, " + number(denoise.radius_px) + " px";
      })
      .def(py::init([](double levels, double radius_px) {
             return Denoise{levels, radius_px};
           }),
           py::arg("levels"), py::arg("radius_px"));
  Record<Sharpen>(m, "Sharpen", "Unsharp masking: level + amount * (level - mean).")
      .field("amount", &Sharpen::amount, "Factor of the difference.")
      .field("radius_px", &Sharpen::radius_px, "Standard deviation of the mean's Gaussian, px.")
      .representation([](const Sharpen& sharpen) {
        return "amount " + number(sharpen.amount) + ", " + number(sharpen.radius_px) + " px";
      })
      .def(py::init([](double amount, double radius_px) {
             return Sharpen{amount, radius_px};
           }),
           py::arg("amount"), py::arg("radius_px"));
}

std::optional<double> focus_distance(const Sensor& s) {
  return s.focus ? std::optional(s.focus->distance_m) : std::nullopt;
}

void bind_sensor(py::module_& m) {
  Record<Sensor>(m, "Sensor",
                 "Conversion of light to grey levels: white * (exposure * level)^gamma, plus "
                 "noise, clipped; then what a camera does to its pictures.")
      .field("exposure", &Sensor::exposure, "Factor of the light.")
      .field("blur_px", &Sensor::blur_px, "Standard deviation of a Gaussian blur, px.")
      .field("noise_levels", &Sensor::noise_levels,
             "Standard deviation of Gaussian noise, levels of an 8-bit picture.")
      .field("bits", &Sensor::bits, "8 (white is 255) or 16 (white is 65535).")
      .field("gamma", &Sensor::gamma, "Below 1 brightens dark parts.")
      .field(
          "vignetting",
          [](const Sensor& s) -> std::variant<std::string, std::vector<double>> {
            if (s.vignetting.cos4) return std::string("cos4");
            return s.vignetting.polynomial;
          },
          "\"cos4\", or the coefficients of 1 + a1 r^2 + a2 r^4 + .., r in half diagonals.")
      .field("focus_distance_m", &focus_distance, "Along the optical axis; None: all is sharp.")
      .field(
          "aperture_m", [](const Sensor& s) { return s.focus ? s.focus->aperture_m : 0; },
          "Diameter of the aperture: focal length / f-number.")
      .field("mosaic", &Sensor::mosaic, "A Mosaic, or None. With it, gamma follows the noise.")
      .field("denoise", &Sensor::denoise, "A Denoise, or None.")
      .field("sharpen", &Sensor::sharpen, "A Sharpen, or None: after denoising.")
      .field("jpeg", &Sensor::jpeg, "Quality of JPEG, or None: after sharpening.")
      .representation([](const Sensor& s) {
        return std::to_string(s.bits) + " bits, blur " + number(s.blur_px) + " px, noise " +
               number(s.noise_levels) + " levels";
      })
      .def(py::init(&sensor_of), py::arg("exposure") = 1.0, py::arg("blur_px") = 0.0,
           py::arg("noise_levels") = 0.0, py::arg("bits") = 8, py::arg("gamma") = 1.0,
           py::arg("vignetting") = std::vector<double>(), py::arg("focus_distance_m") = py::none(),
           py::arg("aperture_m") = 0.0, py::arg("mosaic") = py::none(),
           py::arg("denoise") = py::none(), py::arg("sharpen") = py::none(),
           py::arg("jpeg") = py::none(),
           "`blur_px` and `noise_levels` are standard deviations. `vignetting`: \"cos4\" or "
           "coefficients of 1 + a1 r^2 + a2 r^4 + .., r in half diagonals. With a "
           "`focus_distance_m`, other depths are blurred by the aperture. `mosaic`, `denoise`, "
           "`sharpen` and `jpeg` (quality 1 to 100, of 8 bits) follow each other.");
}

void bind_light(py::module_& m) {
  Record<DirectionalLamp>(m, "DirectionalLamp",
                          "A lamp with parallel rays: adds strength * cosine to a sheet.")
      .field("direction", &DirectionalLamp::direction, "(3,), in which its light travels.")
      .field("strength", &DirectionalLamp::strength, "Light on a sheet that faces it.")
      .representation([](const DirectionalLamp& l) { return "strength " + number(l.strength); })
      .def(py::init(&directional_lamp), py::arg("direction"), py::arg("strength") = 1.0);
  Record<PointLamp>(m, "PointLamp", "A lamp at a point: adds strength * cosine / r^2 to a sheet.")
      .field("position", &PointLamp::position, "(3,), metres.")
      .field("strength", &PointLamp::strength, "Light on a sheet that faces it at 1 m.")
      .representation([](const PointLamp& l) { return "strength " + number(l.strength); })
      .def(py::init(&point_lamp), py::arg("position"), py::arg("strength") = 1.0);
  Record<Light>(m, "Light",
                "The light on sheets: their level is multiplied by `ambient` and what the lamp "
                "adds. Sheets cast no shadows.")
      .field("ambient", &Light::ambient, "Light from everywhere.")
      .field("lamp", &Light::lamp, "A DirectionalLamp or a PointLamp, or None.")
      .field("on_camera", &Light::on_camera, "True: the lamp is given in the camera frame.")
      .representation([](const Light& l) {
        return "ambient " + number(l.ambient) + (l.lamp.index() == 0 ? ", no lamp" : ", a lamp");
      })
      .def(py::init([](double ambient, const Lamp& lamp, bool on_camera) {
             return Light{not_negative(ambient, "ambient"), lamp, on_camera};
           }),
           py::arg("ambient") = 0.0, py::arg("lamp") = py::none(), py::arg("on_camera") = false,
           "`on_camera`: the lamp moves with the camera, and is given in its frame.");
}

}  // namespace

void bind_scene_parts(py::module_& m) {
  bind_processing(m);
  bind_sensor(m);
  bind_light(m);
  Record<Occluder>(m, "Occluder", "A flat opaque object: a convex polygon in the world.")
      .field(
          "corners",
          [](const Occluder& o) { return array_of(std::span<const Eigen::Vector3d>(o.corners)); },
          "(N, 3), metres.")
      .field("level", &Occluder::level, "Grey level, 0 to 1.")
      .representation([](const Occluder& o) {
        return std::to_string(o.corners.size()) + " corners, level " + number(o.level);
      })
      .def(py::init(&occluder_of), py::arg("corners"), py::arg("level") = 0.3,
           "`corners` (N, 3), metres, of a flat convex polygon.");
  m.def("cuboid", &cuboid_of, py::arg("size_m"), py::arg("world_from_cuboid"),
        py::arg("level") = 0.3,
        "A box as six occluders. Its centre is the origin of its frame, its sides (3,) are along "
        "the axes.");
}

}  // namespace tagcal::python
