#include "tagcal/io/formats/formats.hpp"

#include <fmt/format.h>

#include "tagcal/error.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/formats/opencv_camera.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {
namespace {

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
