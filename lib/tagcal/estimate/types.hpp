#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tagcal/camera/model.hpp"
#include "tagcal/estimate/seen_region.hpp"
#include "tagcal/estimate/status.hpp"
#include "tagcal/scene/dataset.hpp"
#include "tagcal/solvers/weak_perspective.hpp"

// What the estimators take and what they return: of a pose (pose.hpp), of a pose with focal length,
// of a calibration (calibrate.hpp).

namespace tagcal {

// A point of a target and the pixel at which it is seen.
struct Correspondence {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // target frame, metres
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

struct PoseOptions {
  double sigma_px = 0;  // noise per coordinate; 0: from the residuals where there are 50 degrees of
                        // freedom, else 0.5 px is assumed, and a warning says so
  int max_iterations = 50;
  bool reject_outliers = true;  // where not all agree, search for those that do
  std::uint64_t seed = 0;       // of the samples that the search takes
  // One per correspondence, or none.
  std::span<const Matrix2> covariance_px2 = {};  // of the pixel; sigma_px is not used then
  std::span<const int> groups = {};  // equal numbers are right or wrong together: a tag's id
};

struct PoseHypothesis {
  Pose camera_from_target;
  // Of (omega rad, tau m) in the camera frame: `retract`. Where turns are hardly known it is wider
  // than the inverse of the information, so that its ellipsoid holds what the likelihood does.
  Matrix6 covariance = Matrix6::Zero();
  double rms_px = 0;       // sqrt(sum |r|^2 / points), of the inliers
  double probability = 1;  // by likelihood, among the hypotheses
  double focal_px = 0;     // that goes with it, where it was estimated; else 0
};

struct PoseEstimate {
  Status status = Status::degenerate;
  std::vector<PoseHypothesis> hypotheses;  // best first; two where a plane fits two poses
  std::vector<std::size_t> outliers;       // correspondences that were left out, ascending
  double sigma_px = 0;                     // what the covariance was computed with
  std::vector<std::string> warnings;

  // The likeliest pose. Precondition: is_answer(status).
  const Pose& camera_from_target() const { return hypotheses.front().camera_from_target; }
};

struct PoseAndFocalOptions : PoseOptions {
  double prior_focal_px = 0;  // what the caller takes the focal length for where the view does not
                              // show it; 0: nothing
};

using Matrix7 = Eigen::Matrix<double, 7, 7, Eigen::DontAlign>;

struct PoseAndFocalEstimate {
  Status status = Status::degenerate;

  // Of an answer: the focal length, its standard deviation and the covariance of (omega, tau, log
  // f) of the likeliest hypothesis, whose own covariance is the upper left block.
  double focal_px = 0;
  double sigma_focal_px = 0;
  Matrix7 covariance = Matrix7::Zero();

  // With focal_not_observable: the poses for the prior focal length (the prior taken as exact), if
  // there is one, best first; and what the view does hold, the poses under weak perspective.
  std::vector<PoseHypothesis> hypotheses;
  std::vector<WeakPerspectivePose> weak_perspective;

  std::vector<std::size_t> outliers;  // correspondences that were left out, ascending
  double sigma_px = 0;                // what the covariance was computed with
  std::vector<std::string> warnings;

  // Precondition: is_answer(status).
  const Pose& camera_from_target() const { return hypotheses.front().camera_from_target; }
};

inline constexpr double kInfinitelyFar = std::numeric_limits<double>::infinity();

// A lens, and how well its free parameters are known.
struct UncertainLens {
  const Model* model = nullptr;
  Lens lens = pinhole(1, 1, 0, 0);
  MatrixX covariance;  // of the model's free parameters
};

// Standard deviation of the projection, in pixels per coordinate, at every node of a grid: of the
// point that the lens sees there at a distance along its ray. What a moved and turned camera
// explains is taken out: nobody who uses the lens would see it, the pose takes it up.
struct ProjectionUncertainty {
  double distance_m = kInfinitelyFar;
  ImageGrid grid;
  MatrixX sigma_px;          // rows x columns; NaN where no ray meets the pixel
  double region_px = 0;      // RMS over the samples of the region; infinite where it has none
  double region_max_px = 0;  // the largest over them
};

struct CalibrateOptions {
  std::string model;  // a name of the ladder; "" or "auto": the smallest that explains the data
  // Noise per coordinate; 0: each corner's own covariance where at least half of them have one (and
  // 0.5 px for the others), with what residuals hold beyond it; else estimated from the residuals.
  double sigma_px = 0;
  bool reject_outliers = true;  // false: all views and corners take part, but for repeated views
  // Where the solver starts, instead of a search: a camera of the data set's image size (its lens
  // is the start for models of that kind), or a focal length, > 0 where it is known.
  std::optional<Camera> start;
  double start_focal_px = 0;
  // Lens parameters that are held at these values, by name: fx, fy, cx, cy, k1, ..; f is fx and fy
  // (HeldModels). Distortion needs a model by its name.
  std::map<std::string, double> fixed;
  // `auto` takes the smallest model whose projection differs from that of the best one by at most
  // this (RMS over the seen region); the difference counts in every standard deviation. >= 0.
  double tolerance_px = 0;
  bool board_warp = false;      // let the board be bent; needs one flat board
  int max_iterations = 100;     // of each solve
  std::size_t num_threads = 1;  // 0: one a core. The answer does not depend on it
  // At which the projection's uncertainty is given, > 0; empty: infinity and the corners' median.
  std::vector<double> distances_m;
};

// One corner that was left out, with its residual under the answer.
struct Outlier {
  std::string image;
  CornerId id;
  double residual_px = 0;  // NaN where the answer does not project it at all
  // By number in the data set: Dataset::views[view].observations[corner]. Names of images are for
  // people: they may be empty or equal.
  std::size_t view = 0;
  std::size_t corner = 0;
};

struct CalibratedView {
  std::string image;
  // With model weak: the point X is seen at scale (R X + t) + centre of the image, t_z = 0 and its
  // covariance NaN.
  Pose camera_from_world;
  Matrix6 covariance = Matrix6::Zero();  // of (omega rad, tau m) in the camera frame: `retract`
  int num_corners = 0;                   // inliers
  double rms_px = 0;
  std::optional<double> scale_px_per_m;  // of model weak
  double scale_sigma_px_per_m = 0;       // NaN where it is not known
  std::optional<Pose> mirrored;  // of model weak and a plane: the other pose, which fits as well
  std::size_t view = 0;          // by number in the data set
};

// One model of the ladder as `auto` saw it.
struct ModelStep {
  std::string model;
  int num_parameters = 0;
  double cost = 0;  // sum of squared (whitened) residuals, each up to the rejection bound
  double bic = 0;
  // RMS over the seen region at the median distance, pose taken out, from the model of lowest BIC;
  // none where the two were not compared.
  std::optional<double> difference_px;
  double weight = 0;     // Akaike's, of a model that counts in the claims beside the answer
  bool taken = false;    // on the way to the answer, or the answer
  std::string sentence;  // why, or why not
};

// Two halves of the views, each by itself, against what their covariances predict. A model that is
// too small or a bent board makes them differ by more, which rms alone hides (mrcal's
// cross-validation).
struct HalvesCheck {
  double difference_px =
      0;  // of their projections, RMS over samples, per coordinate, pose taken out
  double predicted_px = 0;  // standard deviation of that
  double ratio = 0;         // difference / predicted
  bool disagree = false;    // ratio > 2, and chi-square of the parameters beyond p = 0.001
};

// A board that is not flat: a point at (x, y) stands out of it, towards the viewer, by
// bend.x (1 - x'^2) + bend.y (1 - y'^2), with x' and y' from -1 to 1 over the board.
struct BoardWarp {
  Eigen::Vector2d bend_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d sigma_mm = Eigen::Vector2d::Zero();
  double chi_square = 0;  // of a flat board, two degrees of freedom
};

// A combination of parameters that the data leave open.
struct WeakDirection {
  std::string parameter;  // that moves the projection most along it
  double sigma_px = 0;    // what it does to the projection at infinity, RMS where corners were
  std::string sentence;   // what trades off, and what helps
};

// Wall-clock times.
struct CalibrateSeconds {
  double start = 0;  // closed form and consensus
  double solve = 0;
  double covariance = 0;
  double total = 0;
};

struct Calibration {
  Status status = Status::degenerate;
  std::string model;
  // No value without an estimate (degenerate, no_consensus). With a status that is no answer, the
  // lens is where the solver stood, for diagnosis only.
  std::optional<Camera> camera;
  // Of the model's free parameters, in their order; empty if singular. Of `auto` it is
  // unconditional: the other models that the data support count by their weights
  // (ModelStep::weight).
  MatrixX covariance;
  std::vector<double> sigmas;  // standard deviation of each lens parameter; 0 for a held one
  std::map<std::string, double> fixed;  // lens parameters that were held as asked, and their values
  std::vector<ProjectionUncertainty> projection;  // per distance; empty without a covariance
  SeenRegion seen;                                // where in the image the corners were
  std::optional<BoardWarp> board_warp;            // where it was asked for
  std::optional<HalvesCheck> halves;              // of six views and more
  std::vector<WeakDirection> weak_directions;     // the weakest first, three at most
  double rms_px = 0;                              // sqrt(sum |r|^2 / corners), inliers
  double sigma_px = 0;  // noise per coordinate that the covariance was computed with
  bool sigma_from_residuals = false;
  bool sigma_of_corners = false;  // sigma_px is 1, in units of each corner's own and model_error_px
  // Noise per coordinate beyond the corners' own covariances, as the residuals show it: what lens
  // and target are not as modelled.
  double model_error_px = 0;
  // By which all variances grew, since residuals differ from place to place, or halves of the views
  // by more than independent noise makes them.
  double variance_inflation = 1;
  double bic = 0;
  int num_corners = 0;  // inliers
  int num_iterations = 0;
  std::vector<CalibratedView> views;  // those that take part
  std::vector<Outlier> outliers;
  std::vector<ModelStep> steps;  // of `auto`, in the order of the ladder
  std::vector<std::string> warnings;
  CalibrateSeconds seconds;
};

}  // namespace tagcal
