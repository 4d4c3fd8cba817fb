#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tagcal/io/formats/format_table.hpp"

// The formats that have no reader or writer but those of the table (camera_formats.cpp).

namespace tagcal::internal {

// Kalibr's camchain.yaml: cam0, cam1, .. and the transform of each from the one before it.
bool has_kalibr_keys(const YamlValue& top);
CameraFile read_kalibr(const YamlValue& top);
FormatOutput write_kalibr(const CameraFile& file);

// sensor.yaml of the EuRoC data sets: one camera with Kalibr's lenses, and T_BS, its place on the
// body, which is the IMU.
bool has_euroc_keys(const YamlValue& top);
CameraFile read_euroc(const YamlValue& top);
FormatOutput write_euroc(const CameraFile& file);

// The keys of one camera that Kalibr and EuRoC share: resolution, camera_model, intrinsics,
// distortion_model, and coefficients under a key of each.
FileCamera read_kalibr_camera(const YamlValue& camera, std::string_view coefficients_key);

// The keys of a lens in Kalibr's words. Throws Error for a lens that Kalibr does not have.
struct KalibrLens {
  std::string_view camera_model;
  std::string intrinsics;
  std::string_view distortion_model;  // radtan, equidistant, none
  std::string distortion;
};
KalibrLens kalibr_lens(const FileCamera& camera, std::string_view format);

// Cameras of ROS beside its YAML file: the INI file of ROS 1, and a CameraInfo message as
// `rostopic echo` and `ros2 topic echo` print it, the first one if there are several.
bool is_ros_ini(std::string_view text);
CameraFile read_ros_ini(const CameraText& ini);
bool is_ros_message(std::string_view text);
CameraFile read_ros_message(const CameraText& message);

// mrcal's .cameramodel: a text that begins, after comments, with a dictionary of Python that has a
// lens.
bool is_mrcal_model(std::string_view text);
CameraFile read_mrcal(const CameraText& model);
FormatOutput write_mrcal(const CameraFile& file);

// transforms.json of nerfstudio and instant-ngp: a lens, and a pose per picture of a camera that
// looks along -z with y up (OpenGL).
bool has_nerfstudio_keys(const YamlValue& top);
CameraFile read_nerfstudio(const CameraText& transforms);
FormatOutput write_nerfstudio(const CameraFile& file);

// Basalt's calibration.json (cereal's value0): intrinsics, resolution and T_imu_cam of each camera.
bool has_basalt_keys(const YamlValue& top);
CameraFile read_basalt(const YamlValue& top);
FormatOutput write_basalt(const CameraFile& file);

// The JSON of WPILib's WPIcal: camera_matrix (9 numbers) and distortion_coefficients (OpenCV's) of
// one camera, without the size of its pictures.
bool has_wpilib_keys(const YamlValue& top);
CameraFile read_wpilib(const YamlValue& top);
FormatOutput write_wpilib(const CameraFile& file);

// A bag of messages of Foxglove's schemas in JSON, which Foxglove and rerun show
// (https://mcap.dev/spec, https://docs.foxglove.dev/docs/sdk/schemas). At the time of each pose:
//   /camera      foxglove.CameraCalibration, also without poses
//   /tf          foxglove.FrameTransform, the camera in the frame "world"
//   /findings    foxglove.Log, of the findings of the pose
// in one chunk with its index.
FormatOutput write_mcap(const CameraFile& file);

// Poses as a trajectory of the TUM data sets: `timestamp tx ty tz qx qy qz qw`, world from camera.
FormatOutput write_tum(const CameraFile& file);

// Times of poses for formats of trajectories, in seconds, as decimal numbers without a sign: those
// that the poses have, to a microsecond; else the names of their pictures if these are numbers (16
// digits and more: nanoseconds); else 0, 1, 2, ..
struct PoseTimes {
  std::vector<std::string> seconds;  // one for each pose, all different
  std::string note;                  // where they come from
};
PoseTimes times_of(const std::vector<ImagePose>& poses);

}  // namespace tagcal::internal
