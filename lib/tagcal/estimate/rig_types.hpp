#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/types.hpp"
#include "tagcal/scene/rig.hpp"
#include "tagcal/uncertainty/known_rig.hpp"

// Options and results of calibrate_rig (calibrate_rig.hpp) and estimate_rig_pose (pose.hpp).

namespace tagcal {

// How a rig treats the lenses of its cameras.
enum class RigLenses {
  joint,  // estimated from the rig's pictures, with the extrinsics
  fixed,  // as the calibrations that are given; their covariances enter the claims
};

struct RigOptions {
  // Of each camera's own calibration: one for all, or one for each.
  std::vector<CalibrateOptions> calibrate = {CalibrateOptions()};
  RigLenses lenses = RigLenses::joint;
  // By camera, with RigLenses::fixed: what is known of its lens, and the error of a projection by
  // it besides the corners' noise (CalibrationFile::camera_error_px).
  struct KnownCamera {
    UncertainCamera camera;
    double error_px = 0;
  };
  std::vector<KnownCamera> known;
  std::size_t reference = 0;  // the camera whose frame is that of the rig
  // The boards stand still, but their places relative to one another are unknown: the data set's
  // are not used. Each board alone must determine a pose.
  bool find_boards = false;
  // Corrects each view for the time between its stamp and its instant, and estimates one offset a
  // camera for its clock. Needs stamps.
  bool find_clocks = false;
  // Estimates the readout of each camera's rolling shutter by its own calibration
  // (CalibrateOptions::times_s), and takes the motion out of the corners where it is seen. Needs
  // stamps.
  bool find_readouts = false;
};

// One camera of a calibrated rig.
struct RigCameraEstimate {
  std::string name;
  Calibration own;                       // from its own pictures alone, with the readout
  UncertainCamera camera;                // the rig's answer, with its claim
  std::string model;                     // of that lens: it may be larger than the own answer's
  double error_px = 0;                   // as CalibrationFile::camera_error_px
  Pose camera_from_rig;                  // identity for the reference
  Matrix6 covariance = Matrix6::Zero();  // of (omega rad, tau m) in the camera frame: `retract`
  bool is_connected = false;             // false: the extrinsics have no value
  int num_views = 0;                     // that take part
  int num_corners = 0;
  double rms_px = 0;  // sqrt(sum |r|^2 / corners)
  // By how much the rig moves the corners from where the camera's own poses have them, beyond what
  // noise does, over the noise of a coordinate (RMS). Below 0.5 the rig agrees with the camera.
  double excess = 0;
};

// The depth of a point that a pair of cameras sees on the optical axis of the first one.
struct DepthUncertainty {
  double distance_m = 0;
  double sigma_m = 0;      // by the claims of lenses and extrinsics; without noise of the pixels
  double of_lenses_m = 0;  // the part that the lenses cause
};

// Two cameras that have instants in common.
struct RigPair {
  std::size_t a = 0, b = 0;  // cameras, a < b
  int num_instants = 0;      // in common, that take part
  int num_corners = 0;       // seen by both at the same instant, of 100 instants at most
  Pose b_from_a;
  Matrix6 covariance = Matrix6::Zero();
  double baseline_m = 0;
  double sigma_baseline_m = 0;
  // Disagreement of this pair alone with the rig, in standard deviations: the root of the mean
  // square over the six parameters; 0 for two cameras.
  double disagreement = 0;
  double epipolar_px = 0;  // RMS distance of a corner from its epipolar curve
  std::vector<DepthUncertainty> depths;
};

// A camera's clock against that of the reference: its pictures were taken this much later than
// their stamps say, or than the others of the same instants, without stamps.
struct ClockOffset {
  std::size_t camera = 0;
  double offset = 0;  // s; without stamps in distances of neighbouring instants
  double sigma = 0;
  bool in_seconds = false;
};

// "12.3 +- 0.5 ms", or instants.
std::string offset_text(const ClockOffset& clock);

// A board in the world, which is the frame of the board that the reference sees most; or, if the
// places of the boards are known, the world as it is.
struct RigBoard {
  Pose world_from_board;
  Matrix6 covariance = Matrix6::Zero();  // of (omega rad, tau m) in the world: `retract`
  bool is_connected = true;              // false: the pose has no value
};

struct RigInstant {
  std::size_t index = 0;  // in RigDataset::instants
  Pose rig_from_world;
  int num_views = 0;
};

// Two cameras that should see a board at the same time, and where.
struct AdvisedPair {
  std::size_t a = 0, b = 0;
  // The board's distance from `a`; 0: anywhere in the pictures of both.
  double distance_m = 0;
  // Standard deviation of the board's projection into `b` by that of the places of both cameras;
  // infinite: nothing connects them.
  double sigma_px = 0;
  std::string sentence;  // for users: "show the board .."
};

struct RigCalibration {
  Status status = Status::degenerate;
  std::vector<RigCameraEstimate> cameras;
  std::vector<RigPair> pairs;
  std::vector<RigBoard> boards;                // with RigOptions::find_boards: all; else the world
  std::vector<RigInstant> instants;            // that take part
  std::vector<std::size_t> rejected_instants;  // whose views contradict the rig, ascending
  std::vector<std::vector<std::size_t>> groups;  // of connected cameras; one if all are connected
  // With RigOptions::find_clocks those of all cameras but the reference, which were corrected; else
  // those that are significantly off.
  std::vector<ClockOffset> clocks;
  // Of all extrinsics but the reference's, (omega, tau) each, in the order of the cameras, of
  // the boards that were placed, and of the lenses' free parameters (by the model of each
  // `camera`), in the order of the cameras.
  MatrixX covariance;
  double rms_px = 0;
  int num_corners = 0;
  int num_iterations = 0;
  // The pair that would improve the answer most, or connect the cameras. None if no two can see one
  // board, and for other statuses than ok, not_connected and extrinsic_not_observable.
  std::optional<AdvisedPair> next;
  std::vector<Finding> findings;  // of the rig; those of a camera are in its own calibration
  double seconds = 0;
};

// The rig of an answer. Precondition: is_answer(rig.status).
KnownRig known_rig(const RigCalibration& rig);

// Place, baseline and depths of each two cameras of a known rig; nothing of
// instants. None without the covariance.
std::vector<RigPair> pairs_of(const KnownRig& rig);

// The pose of a target before a known camera or rig.
struct SeenPose {
  Pose camera_from_target;
  Matrix6 covariance = Matrix6::Zero();  // of (omega rad, tau m): `retract`; of its own noise alone
  // The step of the pose by parameters that all poses share (6 x k), such as those of
  // KnownRig::covariance. Empty: they are exact.
  MatrixX response = {};
};

struct RigPoseEstimate {
  // As for one camera, whose frame is that of the rig: `camera_from_target` is rig_from_target. Its
  // covariance includes that of the places and lenses of the cameras. `outliers` is empty, see
  // `of_cameras`.
  PoseEstimate rig;
  std::vector<SeenPose> parts;           // by hypothesis: the two parts of its covariance
  std::vector<PoseEstimate> of_cameras;  // of each camera alone; `degenerate` if it sees nothing
  std::vector<std::uint8_t> takes_part;  // by camera
};

}  // namespace tagcal
