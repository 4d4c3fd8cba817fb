#include "tagcal/io/formats/formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/formats/opencv_camera.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {
namespace {

Pose read_transform(const YamlValue& value) {
  if (!value.is_list()) value.fail("must be a 4x4 matrix by rows");
  return read_pose(value);
}

// A chain and places from the IMU that differ by more than this (rad, m) are not of one rig: Kalibr
// prints both with 10 digits and more. Chosen by hand.
constexpr double kContradicts = 1e-3;

// With the IMU's step of Kalibr every camera has its place from the IMU, which becomes the rig.
void use_imu(const std::vector<std::pair<std::string, YamlValue>>& cameras, CameraFile& file) {
  std::vector<std::pair<YamlValue, Pose>> places;
  for (const auto& [name, camera] : cameras)
    if (const auto transform = camera.find("T_cam_imu"))
      places.emplace_back(*transform, read_transform(*transform));
  if (places.empty()) return;
  if (places.size() < file.cameras.size()) {
    file.notes.emplace_back("dropped: T_cam_imu, which not all cameras have");
    return;
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    std::optional<Pose>& place = file.cameras[i].camera_from_rig;
    const Pose from_first = places[i].second * places[0].second.inverse();
    if (place && !(minus(*place, from_first).norm() < kContradicts))
      places[i].first.fail_plainly("contradicts T_cn_cnm1: remove the one that is older");
    place = places[i].second;
  }
  file.rig_is_imu = true;
  file.notes.emplace_back("the rig is the IMU (T_cam_imu)");
}

// What a camera says of the others and of the IMU's clock.
void read_relations(const YamlValue& keys, std::size_t num_cameras, FileCamera& camera,
                    std::vector<std::string>& notes) {
  if (const auto shift = keys.find("timeshift_cam_imu")) camera.imu_time_shift_s = shift->number();
  const auto overlaps = keys.find("cam_overlaps");
  if (!overlaps) return;
  camera.overlaps = numbers_of_cameras(*overlaps, limits::kMaxRigCameras);
  if (std::ranges::all_of(*camera.overlaps, [&](std::size_t i) { return i < num_cameras; })) return;
  camera.overlaps.reset();
  notes.push_back(
      fmt::format("dropped: {}, with cameras that are not in the file", overlaps->path()));
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

// {rows: 4, cols: 4, data}
Pose read_body_from_camera(const YamlValue& value) {
  const Eigen::MatrixXd matrix = read_matrix(value);
  if (matrix.rows() != 4 || matrix.cols() != 4 ||
      !(matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).isZero(1e-9))
    value.fail_plainly("must be 4 x 4 with the last row [0, 0, 0, 1]");
  return place_of_matrix(matrix.topLeftCorner<3, 3>(), matrix.topRightCorner<3, 1>(), value,
                         "the upper left 3x3");
}

}  // namespace

bool has_kalibr_keys(const YamlValue& top) {
  const auto cam0 = top.find("cam0");
  if (cam0 && cam0->is_map()) return true;
  return std::ranges::any_of(top.members(), [](const auto& key) { return is_camera(key.second); });
}

CameraFile read_kalibr(const YamlValue& top) {
  CameraFile file;
  file.format = "kalibr";
  Pose camera_from_rig;
  bool has_rig = true;
  const auto cameras = cameras_of(top);
  for (const auto& [name, keys] : cameras) {
    FileCamera camera = read_kalibr_camera(keys, "distortion_coeffs");
    camera.name = name;
    read_relations(keys, cameras.size(), camera, file.notes);
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

namespace {

std::string chain_item(const FileCamera& camera, std::size_t i) {
  const KalibrLens lens = kalibr_lens(camera, "kalibr");
  const ImageSize& size = camera.calibration.camera.image_size;
  return fmt::format(
      "cam{0}:\n  camera_model: {1}\n  intrinsics: {2}\n  distortion_model: {3}\n"
      "  distortion_coeffs: {4}\n  resolution: [{5}, {6}]\n  cam_overlaps: [{7}]\n"
      "  rostopic: /cam{0}/image_raw\n",
      i, lens.camera_model, lens.intrinsics, lens.distortion_model, lens.distortion, size.width,
      size.height, fmt::join(camera.overlaps.value_or(std::vector<std::size_t>()), ", "));
}

}  // namespace

FormatOutput write_kalibr(const CameraFile& file) {
  FormatOutput output;
  std::string text;
  for (std::size_t i = 0; i < file.cameras.size(); ++i) {
    const FileCamera& camera = file.cameras[i];
    const std::optional<Pose>& place = camera.camera_from_rig;
    text += chain_item(camera, i);
    if (i > 0 && place && file.cameras[i - 1].camera_from_rig) {
      const Pose step = *place * file.cameras[i - 1].camera_from_rig->inverse();
      text += fmt::format("  T_cn_cnm1: {}\n", rows_text(step.matrix()));
    } else if (i > 0) {
      output.notes.push_back(fmt::format("cam{} has no T_cn_cnm1: its place is not known", i));
    }
    if (file.rig_is_imu && place)
      text += fmt::format("  T_cam_imu: {}\n", rows_text(place->matrix()));
    if (camera.imu_time_shift_s)
      text += fmt::format("  timeshift_cam_imu: {}\n", dotted_number(*camera.imu_time_shift_s));
  }
  if (!file.rig_is_imu && file.cameras[0].camera_from_rig &&
      minus(*file.cameras[0].camera_from_rig, Pose()).norm() != 0)
    output.notes.emplace_back("dropped: the place of cam0 in the rig");
  note_numbered(file, output.notes);
  note_no_uncertainty(file, output.notes);
  note_no_poses(file, output.notes);
  output.files = {{"", text}};
  return output;
}

bool has_euroc_keys(const YamlValue& top) {
  return top.find("camera_model") && top.find("intrinsics");
}

CameraFile read_euroc(const YamlValue& top) {
  CameraFile file;
  file.format = "euroc";
  file.cameras.push_back(read_kalibr_camera(top, "distortion_coefficients"));
  file.cameras.front().name = "cam0";
  if (const auto place = top.find("T_BS")) {
    file.cameras.front().camera_from_rig = read_body_from_camera(*place).inverse();
    file.rig_is_imu = true;
  }
  return file;
}

FormatOutput write_euroc(const CameraFile& file) {
  const FileCamera& camera = only_camera(file, "euroc");
  const KalibrLens lens = kalibr_lens(camera, "euroc");
  const ImageSize& size = camera.calibration.camera.image_size;
  using RowMajor = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  const RowMajor body_from_camera = camera.camera_from_rig.value_or(Pose()).inverse().matrix();
  FormatOutput output;
  output.files = {
      {"",
       fmt::format("sensor_type: camera\ncomment: {}\n\nT_BS:\n  cols: 4\n"
                   "  rows: 4\n  data: {}\n\nresolution: [{}, {}]\ncamera_model: {}\n"
                   "intrinsics: {}\ndistortion_model: {}\ndistortion_coefficients: {}\n",
                   text_yaml(camera.name), dotted_list({body_from_camera.data(), 16}), size.width,
                   size.height, lens.camera_model, lens.intrinsics,
                   lens.distortion_model == "radtan" ? "radial-tangential" : lens.distortion_model,
                   lens.distortion)}};
  if (!camera.camera_from_rig)
    output.notes.emplace_back("T_BS is the identity: the place of the camera is not known");
  else if (!file.rig_is_imu)
    output.notes.emplace_back("the body of T_BS is the rig: the place of an IMU is not known");
  note_no_uncertainty(file, output.notes);
  note_no_poses(file, output.notes);
  return output;
}

}  // namespace tagcal::internal
