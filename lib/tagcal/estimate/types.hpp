#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/camera/model.hpp"
#include "tagcal/scene/dataset.hpp"
#include "tagcal/solvers/weak_perspective.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"

// Options and results of the estimators: pose, pose with focal length (pose.hpp), and calibration
// (calibrate.hpp).

namespace tagcal {

// The result of an estimate. Only `ok` and `ambiguous` are answers.
enum class Status {
  ok,
  ambiguous,             // a single view fits two poses; both are given, with probabilities
  focal_not_observable,  // the data do not determine the focal length: sd(f) / f above 10 %
  not_observable,        // the data do not determine other parameters; a finding names them
  degenerate,            // points on a line, repeated points, or too few
  no_consensus,          // too many outliers for one common answer
  not_converged,         // the solver stopped at no minimum
  // Of rigs alone:
  not_connected,             // no instants connect the cameras
  extrinsic_not_observable,  // the data do not determine the place of a camera; a finding says what
  not_synchronous,           // the pictures of an instant were taken at different times
  // Of hand-eye calibrations alone:
  rotation_axes_parallel,  // the translations along an axis are not determined; the rest is
  no_rotation,             // the hand did not turn: no translation is determined
  wrong_direction,         // the robot's poses fit much better when read in another way
};

std::string_view status_name(Status status);  // as in the enum
inline bool is_answer(Status status) { return status == Status::ok || status == Status::ambiguous; }

enum class Severity {
  note,     // no action is needed
  warning,  // there is an answer, with a limitation
  refusal,  // the reason why there is no answer
};
std::string_view severity_name(Severity severity);  // "note", "warning" or "refusal"

// A fact that an estimate reports about its data, target, model or solver
// (docs/reference/findings.md).
struct Finding {
  std::string code;  // such as "direction_weak"; stable between versions
  Severity severity = Severity::warning;
  std::string sentence;  // what was found, what it means, what to do
};
std::vector<std::string> sentences(std::span<const Finding> findings);

// A point of a target and the pixel at which it is observed.
struct Correspondence {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // target frame, metres
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

struct PoseOptions {
  double sigma_px = 0;  // noise per coordinate; 0: estimated from the residuals if they have 50
                        // degrees of freedom, else 0.5 px and the finding `noise_assumed`
  int max_iterations = 50;
  bool reject_outliers = true;  // RANSAC, if one pose does not explain all correspondences
  std::uint64_t seed = 0;       // of RANSAC
  // Empty, or one per correspondence.
  std::span<const Matrix2> covariance_px2 = {};  // of the pixel; replaces sigma_px
  // Empty, or one per correspondence: equal numbers (the id of a tag) are inliers together.
  std::span<const int> groups = {};
};

struct PoseHypothesis {
  Pose camera_from_target;
  // By (omega rad, tau m) in the camera frame: `retract`. Wider than the inverse of the information
  // if the rotation is weakly determined, so that its ellipsoid contains the profile likelihood. It
  // includes the error of the camera if that is not taken as exact: an error that all views by one
  // camera have in common.
  Matrix6 covariance = Matrix6::Zero();
  Matrix6 noise_covariance = Matrix6::Zero();  // the part of the corners' noise alone
  double rms_px = 0;                           // sqrt(sum |r|^2 / points) over the inliers
  double probability = 1;                      // likelihood, normalised over the hypotheses
  double focal_px = 0;                         // of this hypothesis, if it was estimated; else 0
};

struct PoseEstimate {
  Status status = Status::degenerate;
  std::vector<PoseHypothesis> hypotheses;  // best first; two if a plane fits two poses
  std::vector<std::size_t> outliers;       // rejected correspondences by index, ascending
  double sigma_px = 0;                     // noise per coordinate behind the covariance
  std::vector<Finding> findings;

  const Pose& camera_from_target() const;  // the likeliest; throws Error without an answer
};

struct PoseAndFocalOptions : PoseOptions {
  double prior_focal_px = 0;  // used for the poses if the view does not determine f; 0: none
  // The lens is exactly a centred pinhole with square pixels, as that of rendered pictures. Else
  // all standard deviations include what a lens can be instead: principal point, aspect and
  // distortion by the priors of a calibration, as far as the view itself does not exclude them.
  bool exact_pinhole = false;
};

using Matrix7 = Eigen::Matrix<double, 7, 7, Eigen::DontAlign>;

struct PoseAndFocalEstimate {
  Status status = Status::degenerate;

  // If the status is an answer: focal length, its standard deviation, and the covariance of (omega
  // rad, tau m, log f) of the likeliest hypothesis, whose own covariance is the upper left block.
  double focal_px = 0;
  double sigma_focal_px = 0;
  Matrix7 covariance = Matrix7::Zero();

  // Best first. With focal_not_observable: the poses for the prior focal length, which is taken as
  // exact; empty without a prior.
  std::vector<PoseHypothesis> hypotheses;
  std::vector<WeakPerspectivePose> weak_perspective;  // with focal_not_observable only

  std::vector<std::size_t> outliers;  // rejected correspondences by index, ascending
  double sigma_px = 0;                // noise per coordinate behind the covariance
  std::vector<Finding> findings;

  const Pose& camera_from_target() const;  // the likeliest; throws Error without an answer
};

struct CalibrateOptions {
  std::string model;  // a model of the ladder; "" or "auto": the smallest that explains the data
  // Noise per coordinate. 0: if at least half of the corners have a covariance, those (0.5 px for
  // the other corners) and one further variance that the residuals need; else from the residuals.
  double sigma_px = 0;
  bool reject_outliers = true;  // false: all views and corners take part, except repeated views
  // The start of the solver, instead of a search: a camera of the data set's image size (its lens
  // starts the models of that kind), or a focal length (0: none).
  std::optional<Camera> start;
  double start_focal_px = 0;
  // Lens parameters held at these values, by name: fx, fy, cx, cy, k1, ..; f is fx and fy
  // (HeldModels). Distortion coefficients can be held only for a model by name.
  std::map<std::string, double> fixed;
  // `auto` takes the smallest model whose projection differs from that of the best one by at most
  // this (RMS over the seen region); all standard deviations include the difference. >= 0.
  double tolerance_px = 0;
  // Empty, or the source of each view, as the folder of its picture: calibrations from different
  // sources are compared instead of two halves of the views.
  std::vector<std::string> sources;
  // Empty, or the time of each view: the readout of a rolling shutter is estimated, and where it is
  // seen its motion is taken out of the corners; views without neighbours in time are then left
  // out. Finite.
  std::vector<double> times_s;
  bool board_warp = false;      // throws Error unless there is one flat board
  int max_iterations = 100;     // of each solve
  std::size_t num_threads = 1;  // 0: one per core; the answer does not depend on it
  // Distances at which the projection's uncertainty is computed, > 0, after infinity and the median
  // distance of the corners.
  std::vector<double> distances_m;
};

// A rejected corner, with its residual under the answer.
struct Outlier {
  std::string image;
  CornerId id;
  double residual_px = 0;  // NaN if the corner is outside the lens' domain
  // Its place in the data set, Dataset::views[view].observations[corner]. (Names of images may be
  // empty or equal.)
  std::size_t view = 0;
  std::size_t corner = 0;
};

struct CalibratedView {
  std::string image;
  // With model weak: the point X projects to scale (R X + t) + centre of the image; t_z is 0, its
  // covariance NaN.
  Pose camera_from_world;
  Matrix6 covariance = Matrix6::Zero();  // of (omega rad, tau m) in the camera frame: `retract`
  int num_corners = 0;                   // inliers
  // Projected - observed of each inlier, in the order of the view's observations. What the fit
  // knows beside lens and pose is taken out: the shape of the board, and the motion of the rows.
  std::vector<Eigen::Vector2d> residuals_px;
  double rms_px = 0;                     // of these
  std::optional<double> scale_px_per_m;  // with model weak
  double scale_sigma_px_per_m = 0;       // NaN if it is not known
  std::optional<Pose> mirrored;  // with model weak and a plane: the second pose, which fits as well
  std::size_t view = 0;          // index in Dataset::views
};

// One model of the ladder in the choice of `auto`.
struct ModelStep {
  std::string model;
  int num_parameters = 0;
  double cost = 0;  // sum of squared (whitened) residuals, each up to the rejection bound
  double bic = 0;
  // Difference of its projection from that of the model of lowest BIC: RMS over the seen region at
  // the median distance, less a motion of the camera. No value if the two were not compared.
  std::optional<double> difference_px;
  double weight = 0;     // in the claim
  bool taken = false;    // the answer, or a fit that the answer started from
  std::string sentence;  // the reason
};

// Cross-validation (after mrcal): the lenses of two halves of the views are compared. A model that
// is too small, or a bent board, makes them differ by more than their covariances predict, and so
// do the pictures of two cameras.
struct HalvesCheck {
  std::string source;  // the views of this source, and the rest; "": every other view, and the rest
  // Difference of their projections less a motion of the camera, RMS over samples, per coordinate,
  // at infinity or at the median distance of the corners: where it is larger beside its sd.
  double distance_m = 0;
  double difference_px = 0;
  double predicted_px = 0;  // its standard deviation
  // difference_px / predicted_px, or the same of all parameters (the root of chi-square over its
  // degrees of freedom), if that is larger.
  double ratio = 0;
  bool disagree = false;  // ratio > 2, and chi-square of the parameters beyond p = 0.001
};

// How the board differs from its file. A point at (x, y), with x' and y' from -1 to 1 over the
// board, is out of its plane, towards the viewer, by
//   bend.x (1 - x'^2) + bend.y (1 - y'^2) + twist x' y',
// and at y (1 + aspect) instead of y.
struct BoardWarp {
  Eigen::Vector2d bend_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d sigma_mm = Eigen::Vector2d::Zero();
  double twist_mm = 0;
  double sigma_twist_mm = 0;
  double aspect = 0;
  double sigma_aspect = 0;
};

// Readout of a rolling shutter: the time from the first row of the picture to the last, negative if
// the last comes first.
struct Readout {
  double seconds = 0;
  double sigma_s = 0;
  int num_views = 0;     // that have neighbours in time, which show their motion
  bool is_seen = false;  // it is significant (p = 0.0001): its motion is taken out of the corners
};

// Wall-clock times in seconds.
struct CalibrateSeconds {
  double start = 0;  // closed form and robust search
  double solve = 0;
  double covariance = 0;
  double total = 0;
};

struct Calibration {
  Status status = Status::degenerate;
  std::string model;
  // No value without an estimate (degenerate, no_consensus). If the status is no answer, the lens
  // is the last state of the solver, for diagnosis only.
  std::optional<Camera> camera;
  // What is known of the lens: the covariance about `camera`, by the free parameters of the largest
  // model that the data need (`auto`) or of the model asked for. It includes the choice of the
  // model and the priors. Every other uncertainty of the lens follows from it. No value for model
  // weak.
  std::optional<UncertainCamera> claim;
  MatrixX covariance;          // the same by the model's free parameters, in their order (k x k)
  std::vector<double> sigmas;  // standard deviation of each lens parameter; 0 for a held one
  std::map<std::string, double> fixed;  // lens parameters that were held, and their values
  // At infinity, at the median distance of the corners, then at those of the options; empty without
  // a covariance.
  std::vector<ProjectionUncertainty> projection;
  SeenRegion seen;                             // the part of the image with corners
  std::optional<BoardWarp> board_warp;         // with one flat board
  std::optional<HalvesCheck> halves;           // with six views or more
  std::vector<WeakDirection> weak_directions;  // the weakest first, at most three
  double rms_px = 0;                           // sqrt(sum |r|^2 / corners) over the inliers
  double sigma_px = 0;                         // noise per coordinate, by the answer's residuals
  bool sigma_from_residuals = false;
  bool sigma_of_corners = false;  // noise: the corners' own and model_error_px; sigma_px is 1 then
  // Noise per coordinate beyond the corners' own covariances, estimated from the residuals: errors
  // of the models of lens and target.
  double model_error_px = 0;
  // Variance of the views' contributions over that of independent residuals.
  double variance_inflation = 1;
  // px a row. Standard deviation of the displacement of each view's rows against one another, along
  // u and along v, or with finding `rolling_shutter` by each axis of the camera's velocity. 0: the
  // views show none.
  double row_sigma = 0;
  std::optional<Readout> readout;  // with times_s, if views have neighbours in time and move
  int num_corners = 0;             // inliers
  int num_iterations = 0;
  std::vector<CalibratedView> views;  // views that take part
  std::vector<Outlier> outliers;
  std::vector<ModelStep> steps;  // with `auto`, in the order of the ladder
  std::vector<Finding> findings;
  CalibrateSeconds seconds;
};

}  // namespace tagcal
