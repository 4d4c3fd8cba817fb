#include "tagcal/io/scene/scene_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "tagcal/io/text/limits.hpp"
#include "tagcal/scene/render.hpp"

namespace tagcal::internal {
namespace {

DirectionalLamp read_directional(const YamlValue& value) {
  value.allow_only({"direction", "strength"});
  const YamlValue direction = value.at("direction");
  const DirectionalLamp lamp{read_vector(direction), value.at("strength").not_negative()};
  if (lamp.direction.isZero(0)) direction.fail_plainly("must not be zero");
  return lamp;
}

PointLamp read_point(const YamlValue& value) {
  value.allow_only({"position_m", "strength"});
  return {read_vector(value.at("position_m")), value.at("strength").not_negative()};
}

Vignetting read_vignetting(const YamlValue& value) {
  Vignetting vignetting;
  if (value.is_list())
    vignetting.polynomial = value.numbers(1, limits::kMaxVignettingTerms);
  else if (value.is_scalar() && value.text() == "cos4")
    vignetting.cos4 = true;
  else
    value.fail_plainly("must be cos4 or a list of coefficients");
  return vignetting;
}

Focus read_focus(const YamlValue& value) {
  value.allow_only({"distance_m", "f_number", "focal_mm"});
  const double focal_m = value.at("focal_mm").positive() / 1000;
  const YamlValue distance = value.at("distance_m");
  if (!(distance.number() > focal_m))
    distance.fail(fmt::format("must be above the focal length, {} m", focal_m));
  return {distance.number(), focal_m / value.at("f_number").positive()};
}

void read_bits(const YamlValue& value, Sensor& sensor) {
  const double count = value.number();
  if (count != 8 && count != 16) value.fail("must be 8 or 16");
  sensor.bits = static_cast<int>(count);
}

Mosaic read_mosaic(const YamlValue& value) {
  value.allow_only({"pattern", "gains", "demosaic"});
  Mosaic mosaic;
  mosaic.pattern = value.at("pattern").text();
  if (const auto gains = value.find("gains"))
    std::ranges::copy(gains->numbers(3), mosaic.gains.begin());
  if (const auto demosaic = value.find("demosaic")) mosaic.demosaic = demosaic->truth();
  return mosaic;
}

Denoise read_denoise(const YamlValue& value) {
  value.allow_only({"levels", "radius_px"});
  return {value.at("levels").number(), value.at("radius_px").number()};
}

Sharpen read_sharpen(const YamlValue& value) {
  value.allow_only({"amount", "radius_px"});
  return {value.at("amount").number(), value.at("radius_px").number()};
}

RollingShutter read_shutter(const YamlValue& value) {
  RollingShutter shutter;
  const auto readout = value.find("readout_ms"), direction = value.find("direction");
  if (readout) shutter.readout_s = readout->number_in(0, kMostMilliseconds) * 1e-3;
  if (!direction) return shutter;
  if (!readout) direction->fail_plainly("belongs to readout_ms");
  const std::array names = {"down", "up", "right", "left"};  // in the order of ReadDirection
  const auto name = std::ranges::find(names, direction->text());
  if (name == names.end()) direction->fail("must be down, up, right or left");
  shutter.direction = static_cast<ReadDirection>(name - names.begin());
  return shutter;
}

void read_processing(const YamlValue& value, Sensor& sensor) {
  if (const auto mosaic = value.find("mosaic")) sensor.mosaic = read_mosaic(*mosaic);
  if (const auto denoise = value.find("denoise")) sensor.denoise = read_denoise(*denoise);
  if (const auto sharpen = value.find("sharpen")) sensor.sharpen = read_sharpen(*sharpen);
  if (const auto jpeg = value.find("jpeg")) sensor.jpeg = jpeg->whole(1, 100);
}

}  // namespace

Light read_light(const YamlValue& value) {
  value.allow_only({"ambient", "directional", "point", "frame", "on_camera"});
  Light light;
  light.ambient = not_negative_or(value.find("ambient"), 0);
  const auto directional = value.find("directional"), point = value.find("point");
  if (directional && point) point->fail_plainly("does not go with directional: one lamp at most");
  if (directional) light.lamp = read_directional(*directional);
  if (point) light.lamp = read_point(*point);
  if (const auto on_camera = value.find("on_camera")) light.on_camera = on_camera->truth();
  const auto frame = value.find("frame");
  if (light.on_camera && frame) frame->fail_plainly("does not go with on_camera");
  return light;
}

Sensor read_sensor(const YamlValue& value, const Camera& camera) {
  value.allow_only({"exposure", "blur_px", "noise_levels", "bits", "gamma", "vignetting", "focus",
                    "mosaic", "denoise", "sharpen", "jpeg", "readout_ms", "direction"});
  Sensor sensor;
  if (const auto exposure = value.find("exposure")) sensor.exposure = exposure->positive();
  if (const auto blur = value.find("blur_px")) sensor.blur_px = blur->number_in(0, 100);
  sensor.noise_levels = not_negative_or(value.find("noise_levels"), sensor.noise_levels);
  if (const auto bits = value.find("bits")) read_bits(*bits, sensor);
  if (const auto gamma = value.find("gamma")) sensor.gamma = gamma->positive();
  if (const auto vignetting = value.find("vignetting"))
    sensor.vignetting = read_vignetting(*vignetting);
  if (const auto focus = value.find("focus")) sensor.focus = read_focus(*focus);
  sensor.shutter = read_shutter(value);
  read_processing(value, sensor);
  value.within([&] { check_sensor(camera, sensor); });
  return sensor;
}

}  // namespace tagcal::internal
