#include "tagcal/io/formats/formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <vector>

#include "tagcal/camera/model.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {
namespace {

// A list of 4 coefficients; none for the model `none`.
std::vector<double> coefficients(const YamlValue& camera, std::string_view key) {
  const YamlValue value = camera.at(key);
  return value.numbers(4);
}

// With distortion_model none, or without the key.
void need_no_distortion(const YamlValue& camera, std::string_view key) {
  constexpr std::size_t kMost = 100;  // chosen by hand: more than any lens has
  const auto value = camera.find(key);
  if (!value || !value->is_list()) return;
  for (const YamlValue& k : value->items(0, kMost))
    if (k.number() != 0) k.fail("must be 0 without a distortion_model");
}

// pinhole: fu fv pu pv, and a distortion.
FileCamera read_kalibr_pinhole(const YamlValue& camera, const ImageSize& size,
                               std::string_view coefficients_key) {
  std::vector<double> p = camera.at("intrinsics").numbers(4);
  const YamlValue model = camera.at("distortion_model");
  const std::string name = model.text();
  const bool equidistant = name == "equidistant";
  if (name == "fov")
    model.fail_plainly("the lens fov (Devernay & Faugeras) is one that tagcal does not have");
  if (name == "radtan" || name == "radial-tangential" || equidistant) {
    const std::vector<double> k = coefficients(camera, coefficients_key);
    p.insert(p.end(), k.begin(), k.end());
  } else if (name == "none") {
    need_no_distortion(camera, coefficients_key);
  } else {
    model.fail("must be radtan, equidistant, fov or none");
  }
  const std::string where = place(camera, "intrinsics");
  return file_camera("",
                     equidistant ? lens_of(kind_of<Fisheye>(), p, where)
                                 : lens_of(kind_of<Perspective>(), p, where),
                     size);
}

// ds: xi alpha fu fv pu pv; eucm: alpha beta fu fv pu pv.
FileCamera read_spherical(const YamlValue& camera, const std::string& name, const ImageSize& size,
                          std::string_view coefficients_key) {
  const std::vector<double> k = camera.at("intrinsics").numbers(6);
  if (const auto model = camera.find("distortion_model"); model && model->text() != "none")
    model->fail(fmt::format("must be none with {}", name));
  need_no_distortion(camera, coefficients_key);
  const double p[] = {k[2], k[3], k[4], k[5], k[0], k[1]};
  const LensKind& kind = Model::named(name).kind();
  return file_camera("", lens_of(kind, p, place(camera, "intrinsics")), size);
}

// omni: xi fu fv pu pv.
FileCamera read_omni(const YamlValue& camera, const ImageSize& size,
                     std::string_view coefficients_key) {
  const std::vector<double> k = camera.at("intrinsics").numbers(5);
  const auto model = camera.find("distortion_model");
  const bool distorted = model && model->text() != "none";
  if (!distorted) need_no_distortion(camera, coefficients_key);
  std::vector<double> distortion;
  if (distorted) distortion = camera.at(coefficients_key).numbers(1, 4);
  if (std::ranges::any_of(distortion, [](double value) { return value != 0; }))
    camera.at("camera_model")
        .fail_plainly(fmt::format("the lens omni (Mei) with {} is one that tagcal does not have",
                                  model->text()));
  return camera.at("intrinsics").within([&] {
    return file_camera("", unified_from_omni(k[0], k[1], k[2], k[3], k[4]), size);
  });
}

}  // namespace

FileCamera read_kalibr_camera(const YamlValue& camera, std::string_view coefficients_key) {
  const auto resolution = camera.find("resolution");
  const ImageSize size = resolution ? read_image_size_value(*resolution) : ImageSize();
  const YamlValue model = camera.at("camera_model");
  const std::string kind = model.text();
  if (kind == "pinhole") return read_kalibr_pinhole(camera, size, coefficients_key);
  if (kind == "ds" || kind == "eucm") return read_spherical(camera, kind, size, coefficients_key);
  if (kind == "omni") return read_omni(camera, size, coefficients_key);
  model.fail("must be pinhole, ds, eucm or omni");
}

KalibrLens kalibr_lens(const FileCamera& camera, std::string_view format) {
  const Lens& lens = camera.calibration.camera.lens;
  const std::span<const double> p = parameters(lens);
  KalibrLens keys{.camera_model = "pinhole",
                  .distortion_model = is_fisheye(camera) ? "equidistant" : "radtan"};
  std::vector<double> intrinsics(p.begin(), p.begin() + 4);
  std::vector<double> distortion(p.begin() + 4,
                                 p.begin() + std::min<std::ptrdiff_t>(8, std::ssize(p)));
  if (kind_of(lens).parameters[4].role == ParameterRole::shape && kind_of(lens).is_central) {
    keys.camera_model = full_model(lens).name();  // ds, eucm: Kalibr's names as well
    keys.distortion_model = "none";
    intrinsics.insert(intrinsics.begin(), distortion.begin(), distortion.end());
    distortion.clear();
  } else if (!is_fisheye(camera)) {
    need_zero_from(8, perspective_numbers(camera, format),
                   fmt::format("{}'s radtan lens (k1 k2 p1 p2)", format));
  }
  keys.intrinsics = dotted_list(intrinsics);
  keys.distortion = dotted_list(distortion);
  return keys;
}

}  // namespace tagcal::internal
