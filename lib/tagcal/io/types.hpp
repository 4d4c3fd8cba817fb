#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/estimate/types.hpp"
#include "tagcal/geometry/pose.hpp"
#include "tagcal/uncertainty/seen_region.hpp"

// What files of cameras hold (calibration_file.hpp, camera_file.hpp).

namespace tagcal {

// A camera with what a calibration knows of it; files of other programs have the camera only.
struct CalibrationFile {
  Camera camera;
  std::string model;                         // "": not in the file
  std::map<std::string, double> fixed = {};  // lens parameters that were held
  std::vector<double> sigmas;                // of the lens parameters; empty: not in the file
  MatrixX covariance;                        // of the free parameters; empty: not in the file
  SeenRegion seen;                           // region of the corners; empty: not in the file
  // Error of a projection by this camera per coordinate, besides the noise of a corner: the error
  // of lens and target that the residuals show (all of the residuals if the corners had no
  // covariances) and the projection's uncertainty. No value if it is not in the file.
  std::optional<double> camera_error_px = std::nullopt;
  std::vector<Finding> findings = {};  // of the calibration; a code may be empty: not in the file
  // Calibration::claim, by the free parameters of this model; empty: not in the file, which has
  // `covariance` instead. uncertain_camera has both cases.
  std::string claim_model = {};
  MatrixX claim_covariance = {};
};

// The claim, the one source of every uncertainty of a lens. Without one (model weak) the lens has
// no model. Precondition: calibration.camera has a value.
UncertainCamera uncertain_camera(const Calibration& calibration);

// The same of a camera's file. Without a covariance the lens has no model and is taken as exact.
UncertainCamera uncertain_camera(const CalibrationFile& file);

// One camera of a file of any program.
struct FileCamera {
  std::string name;             // in the file, for example "cam0"; may be empty
  CalibrationFile calibration;  // an image size of 0 x 0: not in the file
  // The place of the camera in its rig, or in the frame of the first camera, or of the IMU.
  std::optional<Pose> camera_from_rig = std::nullopt;
  // Kalibr's cam_overlaps: the numbers of the cameras that saw the target at the same instants.
  std::optional<std::vector<std::size_t>> overlaps = std::nullopt;
  // Kalibr's timeshift_cam_imu: a stamp of the IMU less that of a picture of the same time.
  std::optional<double> imu_time_shift_s = std::nullopt;
  // Of a stereo pair, to be written: R (rectified_from_camera), P and Q as of cv::stereoRectify.
  struct Rectification {
    Eigen::Matrix<double, 3, 3, Eigen::DontAlign> rotation;
    Eigen::Matrix<double, 3, 4, Eigen::DontAlign> projection;
    Eigen::Matrix<double, 4, 4, Eigen::DontAlign> disparity_to_depth;
  };
  std::optional<Rectification> rectification = std::nullopt;
};

// Where a camera was when it took a picture.
struct ImagePose {
  std::string image;
  std::size_t camera = 0;  // index in CameraFile::cameras
  Pose camera_from_world;
  std::optional<double> time_s = std::nullopt;  // Unix time, or since the first frame of a video
  std::vector<Finding> findings = {};           // of the pose
};

// A format of files of cameras.
struct CameraFormat {
  std::string_view name;     // tagcal, opencv, kalibr, ..
  std::string_view program;  // and file
  std::string_view lenses;   // that are read and written
  bool several = false;      // holds several cameras
  bool pair = false;         // holds one camera, or two and the place of the second
  bool only_poses = false;
  bool only_written = false;
  bool folder = false;      // of files, unless the name has the ending
  std::string_view file;    // its usual name
  std::string_view ending;  // of names that stand for the format; "": none
  // Of a format with one file a camera: the names of the files of several cameras in a folder, {}
  // for the name of a camera. "": the format has no such folders.
  std::string_view each = "";
  bool rectified = false;  // two of those hold the rectification of the pair
};

struct CameraFile {
  std::string format;               // a name of camera_formats()
  std::vector<FileCamera> cameras;  // one or more
  std::vector<ImagePose> poses;     // empty: not in the file
  std::vector<std::string> notes;   // what was changed or dropped, a sentence each
  // Of (omega rad, tau m) of all camera_from_rig in turn (`retract`), zero for the reference, then
  // of the free parameters of all lenses, by the models of uncertain_camera; empty: not in the
  // file, as in those of other programs.
  MatrixX rig_covariance = {};
  // The frame of the rig is that of an IMU, or of the body that other programs place it on.
  bool rig_is_imu = false;
  std::vector<Finding> findings = {};    // of a rig; those of a camera are in its calibration
  std::string frame_of_poses = "world";  // what files call the frame that the poses are in
};

// The frames of a video or of a bag's topic (sequence_file.hpp), in the order of their times.
struct ImageSequence {
  ImageSize size;               // of a frame, turned as a video says
  std::vector<double> times_s;  // of the frames, from the first one on
  // The Unix time of the first frame; 0: not known. Of a bag by the stamps of the pictures, or by
  // the times of recording if a picture has none.
  double start_s = 0;
  bool is_interlaced = false;  // odd and even rows were taken at different times
  bool is_uneven = false;      // frames do not follow one another at equal times
  bool is_cut_off = false;     // the file ends within a frame: those until there
};

}  // namespace tagcal
