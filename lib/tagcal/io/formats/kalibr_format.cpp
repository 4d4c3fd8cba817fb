#include "tagcal/io/formats/kalibr_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {
namespace {

Pose read_transform(const YamlValue& value) {
  if (!value.is_list()) value.fail("must be a 4x4 matrix by rows");
  return read_pose(value);
}

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
FileCamera read_pinhole(const YamlValue& camera, const ImageSize& size,
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
  try {
    return file_camera("", unified_from_omni(k[0], k[1], k[2], k[3], k[4]), size);
  } catch (const Error& error) {
    throw Error(place(camera, "intrinsics") + ": " + error.what());
  }
}

FileCamera read_camera(const YamlValue& camera, std::string_view coefficients_key) {
  const auto resolution = camera.find("resolution");
  const ImageSize size = resolution ? read_image_size_value(*resolution) : ImageSize();
  const YamlValue model = camera.at("camera_model");
  const std::string kind = model.text();
  if (kind == "pinhole") return read_pinhole(camera, size, coefficients_key);
  if (kind == "ds" || kind == "eucm") return read_spherical(camera, kind, size, coefficients_key);
  if (kind == "omni") return read_omni(camera, size, coefficients_key);
  model.fail("must be pinhole, ds, eucm or omni");
}

// The lens' keys, as the readers above take them.
std::string lens_yaml(const FileCamera& camera) {
  const Lens& lens = camera.calibration.camera.lens;
  const std::span<const double> p = parameters(lens);
  std::string_view model = "pinhole",
                   distortion_model = is_fisheye(camera) ? "equidistant" : "radtan";
  std::vector<double> intrinsics(p.begin(), p.begin() + 4);
  std::vector<double> distortion(p.begin() + 4,
                                 p.begin() + std::min<std::ptrdiff_t>(8, std::ssize(p)));
  if (kind_of(lens).parameters[4].role == ParameterRole::shape && kind_of(lens).is_central) {
    model = full_model(lens).name();  // ds, eucm: Kalibr's names as well
    distortion_model = "none";
    intrinsics.insert(intrinsics.begin(), distortion.begin(), distortion.end());
    distortion.clear();
  } else if (!is_fisheye(camera)) {
    need_zero_from(8, perspective_numbers(camera, "kalibr"), "kalibr's radtan lens (k1 k2 p1 p2)");
  }
  return fmt::format(
      "  camera_model: {}\n  intrinsics: {}\n  distortion_model: {}\n  distortion_coeffs: {}\n",
      model, dotted_list(intrinsics), distortion_model, dotted_list(distortion));
}

// With the IMU's step of Kalibr every camera has its place from the IMU, which becomes the rig.
void use_imu(const std::vector<std::pair<std::string, YamlValue>>& cameras, CameraFile& file) {
  std::vector<Pose> camera_from_imu;
  for (const auto& [name, camera] : cameras)
    if (const auto transform = camera.find("T_cam_imu"))
      camera_from_imu.push_back(read_transform(*transform));
  if (camera_from_imu.size() == file.cameras.size()) {
    for (std::size_t i = 0; i < file.cameras.size(); ++i)
      file.cameras[i].camera_from_rig = camera_from_imu[i];
    file.notes.emplace_back("the rig is the IMU (T_cam_imu)");
  } else if (!camera_from_imu.empty()) {
    file.notes.emplace_back("dropped: T_cam_imu, which not all cameras have");
  }
  if (!cameras.empty() && cameras.front().second.find("timeshift_cam_imu"))
    file.notes.emplace_back("dropped: timeshift_cam_imu");
}

bool is_camera(const YamlValue& value) {
  return value.is_map() && value.find("camera_model") && value.find("intrinsics");
}

// The number of a key "cam12"; no value for other keys.
std::optional<int> camera_number(std::string_view key) {
  if (!key.starts_with("cam") || key.size() < 4 || key.size() > 9) return std::nullopt;
  if (key.find_first_not_of("0123456789", 3) != std::string_view::npos) return std::nullopt;
  int number = 0;
  std::from_chars(key.data() + 3, key.data() + key.size(), number);
  return number;
}

// The cameras by their keys: cam0, cam1, .. by their numbers, none of which may be missing, or
// cameras with other names in the order of the file.
std::vector<std::pair<std::string, YamlValue>> cameras_of(const YamlValue& top) {
  std::map<int, YamlValue> by_number;
  std::vector<std::pair<std::string, YamlValue>> cameras;
  for (const auto& [key, value] : top.members()) {
    if (const auto number = camera_number(key)) by_number.emplace(*number, value);
    if (is_camera(value)) cameras.emplace_back(key, value);
  }
  if (by_number.empty() || by_number.size() < cameras.size()) return cameras;
  cameras.clear();
  for (int i = 0; std::ssize(cameras) < std::ssize(by_number); ++i) {
    const std::string name = fmt::format("cam{}", i);
    const auto found = by_number.find(i);
    cameras.emplace_back(name, found == by_number.end() ? top.at(name) : found->second);
  }
  return cameras;
}

}  // namespace

bool has_kalibr_keys(const YamlValue& top) {
  const auto cam0 = top.find("cam0");
  if (cam0 && cam0->is_map()) return true;
  return std::ranges::any_of(top.members(), [](const auto& key) { return is_camera(key.second); });
}

bool has_euroc_keys(const YamlValue& top) {
  return top.find("camera_model") && top.find("intrinsics");
}

CameraFile read_kalibr(const YamlValue& top) {
  CameraFile file;
  file.format = "kalibr";
  Pose camera_from_rig;
  bool has_rig = true;
  const auto cameras = cameras_of(top);
  for (const auto& [name, keys] : cameras) {
    FileCamera camera = read_camera(keys, "distortion_coeffs");
    camera.name = name;
    if (!file.cameras.empty()) {
      const auto transform = keys.find("T_cn_cnm1");
      has_rig = has_rig && transform;
      if (transform) camera_from_rig = read_transform(*transform) * camera_from_rig;
    }
    if (has_rig) camera.camera_from_rig = camera_from_rig;
    file.cameras.push_back(std::move(camera));
  }
  use_imu(cameras, file);
  return file;
}

CameraFile read_euroc(const YamlValue& top) {
  CameraFile file;
  file.format = "kalibr";
  file.cameras.push_back(read_camera(top, "distortion_coefficients"));
  file.cameras.front().name = "cam0";
  file.notes.emplace_back("dropped: T_BS, the place of the camera on the body");
  return file;
}

FormatOutput write_kalibr(const CameraFile& file) {
  FormatOutput output;
  std::string text;
  for (std::size_t i = 0; i < file.cameras.size(); ++i) {
    const FileCamera& camera = file.cameras[i];
    const ImageSize& size = camera.calibration.camera.image_size;
    text += fmt::format(
        "cam{0}:\n{1}  resolution: [{2}, {3}]\n  cam_overlaps: []\n  rostopic: "
        "/cam{0}/image_raw\n",
        i, lens_yaml(camera), size.width, size.height);
    if (i == 0) continue;
    if (camera.camera_from_rig && file.cameras[i - 1].camera_from_rig) {
      const Pose step = *camera.camera_from_rig * file.cameras[i - 1].camera_from_rig->inverse();
      text += fmt::format("  T_cn_cnm1: {}\n", rows_text(step.matrix()));
    } else {
      output.notes.push_back(fmt::format("cam{} has no T_cn_cnm1: its place is not known", i));
    }
  }
  if (!file.cameras.empty() && file.cameras[0].camera_from_rig &&
      minus(*file.cameras[0].camera_from_rig, Pose()).norm() != 0)
    output.notes.emplace_back("dropped: the place of cam0 in the rig");
  note_no_uncertainty(file, output.notes);
  note_no_poses(file, output.notes);
  output.files = {{"", text}};
  return output;
}

}  // namespace tagcal::internal
