#include "tagcal/io/formats/formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "tagcal/error.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {
namespace {

// Names of coefficients behind fx fy cx cy, in the order of the lens' parameters.
struct CameraType {
  std::string_view name;
  const LensKind* lens;
  std::initializer_list<std::string_view> coefficients;
};

const std::array<CameraType, 6>& camera_types() {
  static const std::array<CameraType, 6> all = {
      {{"pinhole", &kind_of<Perspective>(), {}},
       {"pinhole-radtan8",
        &kind_of<Perspective>(),
        {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}},
       {"kb4", &kind_of<Fisheye>(), {"k1", "k2", "k3", "k4"}},
       {"ds", &kind_of<DoubleSphere>(), {"xi", "alpha"}},
       {"eucm", &kind_of<ExtendedUnified>(), {"alpha", "beta"}},
       {"ucm", &kind_of<ExtendedUnified>(), {"alpha"}}}};
  return all;
}

// The smallest of Basalt's kinds that has the lens.
const CameraType& kind_of_camera(const FileCamera& camera) {
  const Lens& lens = camera.calibration.camera.lens;
  const std::span<const double> p = parameters(lens);
  const bool distorted = std::any_of(p.begin() + 4, p.end(), [](double k) { return k != 0; });
  const std::size_t needed = distorted ? p.size() - 4 : 0;
  for (const CameraType& kind : camera_types())
    if (kind.lens == &kind_of(lens) && kind.coefficients.size() >= needed) return kind;
  perspective_numbers(camera, "basalt");  // throws for a lens that Basalt does not have
  return camera_types().front();
}

// Throws Error for a coefficient that the lens does not have. rpmax is a limit of visibility.
void need_no_others(const YamlValue& numbers, const CameraType& kind) {
  constexpr std::string_view kOthers[] = {"fx", "fy", "cx", "cy", "rpmax"};
  for (const auto& [key, value] : numbers.members()) {
    if (std::ranges::count(kOthers, key) > 0 || std::ranges::count(kind.coefficients, key) > 0)
      continue;
    if (value.number() != 0)
      value.fail(fmt::format("must be 0: the lens {} has no such coefficient", kind.name));
  }
}

FileCamera read_camera(const YamlValue& value, const std::string& name, const ImageSize& size) {
  const YamlValue type = value.at("camera_type");
  const YamlValue numbers = value.at("intrinsics");
  const auto kind = std::ranges::find(camera_types(), type.text(), &CameraType::name);
  if (kind == camera_types().end()) {
    if (type.text() == "fov") type.fail_plainly("the lens fov is one that tagcal does not have");
    type.fail("must be pinhole, pinhole-radtan8, kb4, ds, eucm or ucm");
  }
  std::vector<double> p;
  for (const std::string_view key : {"fx", "fy", "cx", "cy"}) p.push_back(numbers.at(key).number());
  for (const std::string_view key : kind->coefficients) p.push_back(numbers.at(key).number());
  need_no_others(numbers, *kind);
  const std::string where = place(value, "intrinsics");
  return file_camera(name, lens_of(*kind->lens, p, where), size);
}

Pose read_imu_from_camera(const YamlValue& value) {
  const auto number = [&](std::string_view key) { return value.at(key).number(); };
  return place_of_quaternion({number("qw"), number("qx"), number("qy"), number("qz")},
                             {number("px"), number("py"), number("pz")}, value, "qx qy qz qw ");
}

std::string intrinsics_json(const FileCamera& camera) {
  const CameraType& kind = kind_of_camera(camera);
  const std::span<const double> p = parameters(camera.calibration.camera.lens);
  std::string text = fmt::format(
      "{{\"camera_type\": \"{}\", \"intrinsics\": {{\"fx\": {}, \"fy\": {}, \"cx\": {}, \"cy\": {}",
      kind.name, dotted_number(p[0]), dotted_number(p[1]), dotted_number(p[2]),
      dotted_number(p[3]));
  std::size_t i = 4;
  for (const std::string_view key : kind.coefficients)
    text += fmt::format(", \"{}\": {}", key, dotted_number(p[i++]));
  // Basalt takes points beyond this radius of (X/Z, Y/Z) as not visible; 0: no limit.
  if (kind.name == "pinhole-radtan8") {
    const double radius = std::get<Perspective>(camera.calibration.camera.lens).max_radius();
    text += fmt::format(", \"rpmax\": {}", std::isfinite(radius) ? dotted_number(radius) : "0.0");
  }
  return text + "}}";
}

std::string pose_json(const Pose& pose) {
  const Eigen::Quaterniond q = pose.rotation();
  const Eigen::Vector3d& t = pose.translation();
  return fmt::format(
      "{{\"px\": {}, \"py\": {}, \"pz\": {}, \"qx\": {}, \"qy\": {}, \"qz\": {}, \"qw\": {}}}",
      dotted_number(t.x()), dotted_number(t.y()), dotted_number(t.z()), dotted_number(q.x()),
      dotted_number(q.y()), dotted_number(q.z()), dotted_number(q.w()));
}

}  // namespace

bool has_basalt_keys(const YamlValue& top) { return top.find("value0").has_value(); }

CameraFile read_basalt(const YamlValue& top) {
  const YamlValue value = top.at("value0");
  const std::vector<YamlValue> intrinsics = value.at("intrinsics").items(1, 1000);
  const std::vector<YamlValue> sizes =
      value.at("resolution").items(intrinsics.size(), intrinsics.size());
  std::vector<YamlValue> poses;
  if (const auto list = value.find("T_imu_cam"))
    poses = list->items(intrinsics.size(), intrinsics.size());
  CameraFile file;
  file.format = "basalt";
  for (std::size_t i = 0; i < intrinsics.size(); ++i) {
    FileCamera camera =
        read_camera(intrinsics[i], fmt::format("cam{}", i), read_image_size_value(sizes[i]));
    if (!poses.empty()) camera.camera_from_rig = read_imu_from_camera(poses[i]).inverse();
    file.cameras.push_back(std::move(camera));
  }
  file.rig_is_imu = !poses.empty();
  if (const auto shift = value.find("cam_time_offset_ns"); shift && shift->number() != 0)
    file.notes.emplace_back("dropped: cam_time_offset_ns");
  for (const std::string_view key : {"calib_accel_bias", "calib_gyro_bias", "vignette"})
    if (value.find(key) && value.at(key).is_list() &&
        !value.at(key).items(0, limits::kMaxMatrixSide).empty())
      file.notes.push_back(fmt::format("dropped: {}", key));
  return file;
}

FormatOutput write_basalt(const CameraFile& file) {
  std::string poses, intrinsics, sizes;
  bool rig_known = true;
  for (const FileCamera& camera : file.cameras) {
    const std::string separator = sizes.empty() ? "" : ",\n      ";
    const Pose imu_from_camera = camera.camera_from_rig.value_or(Pose()).inverse();
    const ImageSize& size = camera.calibration.camera.image_size;
    rig_known = rig_known && camera.camera_from_rig;
    poses += separator + pose_json(imu_from_camera);
    intrinsics += separator + intrinsics_json(camera);
    sizes += separator + fmt::format("[{}, {}]", size.width, size.height);
  }
  FormatOutput output;
  output.files = {
      {"", fmt::format("{{\n  \"value0\": {{\n    \"T_imu_cam\": [\n      {}],\n"
                       "    \"intrinsics\": [\n      {}],\n"
                       "    \"resolution\": [\n      {}],\n"
                       "    \"calib_accel_bias\": [0, 0, 0, 0, 0, 0, 0, 0, 0],\n"
                       "    \"calib_gyro_bias\": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],\n"
                       "    \"imu_update_rate\": 200.0,\n"
                       "    \"accel_noise_std\": [0.016, 0.016, 0.016],\n"
                       "    \"gyro_noise_std\": [0.000282, 0.000282, 0.000282],\n"
                       "    \"accel_bias_std\": [0.001, 0.001, 0.001],\n"
                       "    \"gyro_bias_std\": [0.0001, 0.0001, 0.0001],\n"
                       "    \"cam_time_offset_ns\": 0,\n    \"vignette\": []\n  }}\n}}\n",
                       poses, intrinsics, sizes)}};
  output.notes.emplace_back(
      !rig_known
          ? "T_imu_cam is the identity and the values of the IMU are Basalt's examples: only "
            "the lenses are known"
      : file.rig_is_imu
          ? "the values of the IMU are Basalt's examples: only the cameras are known"
          : "the IMU of T_imu_cam is the rig, and its values are Basalt's examples: only the "
            "cameras are known");
  note_numbered(file, output.notes);
  note_no_uncertainty(file, output.notes);
  note_no_poses(file, output.notes);
  return output;
}

}  // namespace tagcal::internal
