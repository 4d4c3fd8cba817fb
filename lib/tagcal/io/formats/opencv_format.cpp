#include "tagcal/io/formats/opencv_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "tagcal/io/formats/corner_lists.hpp"
#include "tagcal/io/formats/opencv_camera.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {
namespace {

// OpenCV's sample program: a rotation vector and a translation per picture, without its name.
void read_extrinsics(const YamlValue& value, CameraFile& file) {
  const Eigen::MatrixXd rows = read_matrix(value);
  if (rows.cols() != 6)
    value.fail_plainly(
        fmt::format("must have 6 columns (rotation vector, translation), got {}", rows.cols()));
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const Eigen::RowVectorXd row = rows.row(i);
    file.poses.push_back({view_name(static_cast<std::size_t>(i)), 0,
                          Pose(exp_rotation(row.head<3>().transpose()), row.tail<3>())});
  }
  file.notes.push_back(
      fmt::format("extrinsic_parameters has no names of pictures: they are view0000 to {}",
                  file.poses.back().image));
}

// ROS: the rig is the rectified frame of the camera with P[3] = 0. A camera x is there R x, moved
// by the P[3] = -f b of its baseline. Messages without a rectification have zeros.
void read_rectified_place(const YamlValue& top, CameraFile& file) {
  const auto rotation = top.find("rectification_matrix");
  const Eigen::MatrixXd p = read_matrix(top.at("projection_matrix"));
  const Eigen::MatrixXd r = rotation ? read_matrix(*rotation) : Eigen::MatrixXd();
  Pose& place = file.cameras[0].camera_from_rig.emplace();
  if (p.rows() == 3 && p.cols() == 4 && p(0, 0) > 0 && p(1, 1) > 0 && r.rows() == 3 &&
      r.cols() == 3 && !r.isZero())
    place = place_of_matrix(r, Eigen::Vector3d::Zero(), *rotation).inverse() *
            Pose(Eigen::Quaterniond::Identity(), {p(0, 3) / p(0, 0), p(1, 3) / p(1, 1), 0});
  file.notes.emplace_back(minus(place, Pose()).isZero()
                              ? "dropped: rectification_matrix and projection_matrix"
                              : "dropped: the rectified image (projection_matrix); the rig is the "
                                "rectified frame");
}

// The place of the second camera in the frame of the first one.
Pose read_right_from_left(const YamlValue& top) {
  const YamlValue rotation = top.at("R"), translation = top.at("T");
  const Eigen::MatrixXd r = read_matrix(rotation), t = read_matrix(translation);
  if (r.rows() != 3 || r.cols() != 3) rotation.fail_plainly("must be 3 x 3");
  if (t.size() != 3) translation.fail_plainly("must have 3 values");
  return place_of_matrix(r, {t(0), t(1), t(2)}, rotation);
}

// A stereo pair by OpenCV's stereo_calib: intrinsics.yml, and extrinsics.yml.
CameraFile read_stereo(const YamlValue& top, const YamlValue& extrinsics) {
  CameraFile file;
  file.format = "opencv";
  for (const auto& [name, matrix, distortion] :
       {std::array{"left", "M1", "D1"}, std::array{"right", "M2", "D2"}}) {
    const OpencvKeys keys{"image_width", "image_height", matrix, distortion};
    FileCamera camera;
    camera.name = name;
    camera.calibration = read_opencv_camera(top, keys, file.notes);
    file.cameras.push_back(std::move(camera));
  }
  if (!extrinsics.find("R") && !extrinsics.find("T")) return file;
  file.cameras[0].camera_from_rig = Pose();
  file.cameras[1].camera_from_rig = read_right_from_left(extrinsics);
  for (const std::string_view key : {"R1", "P1", "Q"})
    if (extrinsics.find(key)) {
      file.notes.emplace_back("dropped: the rectification (R1, R2, P1, P2, Q)");
      break;
    }
  return file;
}

}  // namespace

void read_views(const YamlValue& views, CameraFile& file) {
  std::set<std::string> names;
  for (const YamlValue& view : views.items(0, limits::kMaxListedPoses)) {
    const Eigen::Quaterniond rotation = read_rotation(view.at("rotation"));
    file.poses.push_back(
        {read_image_name(view.at("image"), names), 0,
         Pose(rotation, Eigen::Vector3d::Map(view.at("translation_m").numbers(3).data()))});
  }
}

bool has_opencv_keys(const YamlValue& top) {
  constexpr std::string_view kKeys[] = {"camera_matrix",
                                        "Camera_Matrix",
                                        "cameraMatrix",
                                        "image_width",
                                        "image_height",
                                        "distortion_coefficients",
                                        "M1"};
  return std::ranges::any_of(kKeys,
                             [&](std::string_view key) { return top.find(key).has_value(); });
}

bool is_pair_without_place(const YamlValue& top) {
  return top.find("M1") && !top.find("R") && !top.find("T");
}

void note_sent_part(const YamlValue& top, const ImageSize& size, std::vector<std::string>& notes) {
  if (const auto roi = top.find("roi"); roi && roi->is_map()) {
    const auto side = [&](const char* key) {
      const auto value = roi->find(key);
      return value ? value->whole(0, limits::kMaxSidePx) : 0;
    };
    const int x = side("x_offset"), y = side("y_offset");
    const ImageSize part{side("width"), side("height")};
    if (part.width > 0 && part.height > 0 && part != size)
      notes.push_back(
          fmt::format("roi: the camera is that of the whole picture, of which the driver sends a "
                      "part; tagcal convert --crop {},{},{}x{} takes the part",
                      x, y, part.width, part.height));
  }
  for (const char* const key : {"binning_x", "binning_y"})
    if (const auto binning = top.find(key); binning && binning->number() > 1)
      notes.push_back(
          fmt::format("{}: the camera is that of the pictures before binning; "
                      "tagcal convert --resize takes the other size",
                      key));
}

CameraFile read_opencv(const YamlValue& top, const std::optional<YamlValue>& extrinsics) {
  if (top.find("M1")) return read_stereo(top, extrinsics.value_or(top));
  CameraFile file;
  FileCamera camera;
  camera.calibration = read_opencv_camera(top, opencv_keys_of(top), file.notes);
  read_uncertainty(top, camera.calibration);
  if (const auto name = top.find("camera_name")) camera.name = name->text();
  file.cameras.push_back(std::move(camera));
  if (const auto views = top.find("views"); views && top.find("model")) read_views(*views, file);
  if (const auto rows = top.find("extrinsic_parameters")) {
    if (!file.poses.empty()) rows->fail_plainly("is given beside views: only one is possible");
    read_extrinsics(*rows, file);
  }
  const bool ros = top.find("distortion_model") || top.find("camera_name");
  file.format = top.find("model") ? "tagcal" : ros ? "ros" : "opencv";
  if (ros && top.find("projection_matrix")) read_rectified_place(top, file);
  if (ros) note_sent_part(top, file.cameras[0].calibration.camera.image_size, file.notes);
  return file;
}

}  // namespace tagcal::internal
