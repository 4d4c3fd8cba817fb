#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/estimate/rig_types.hpp"

namespace tagcal::internal {

// The pose of a view by its own corners, under its camera's own lens.
struct OwnPose {
  Pose camera_from_world;
  Matrix6 covariance = Matrix6::Zero();  // of (omega, tau): `retract`; for noise 1 and a known lens
  double cost = 0;                       // sum of squared whitened residuals
};

// When a view was taken, and what it shows.
struct ViewPlace {
  std::optional<std::size_t> instant;  // none: a view alone
  std::size_t board = 0;               // 0 if the places of all boards are known
};

// The views of a rig, and their places, by camera and view.
struct PlacedViews {
  std::shared_ptr<const RigDataset> data;
  std::vector<std::vector<ViewPlace>> places;
  std::size_t num_boards = 1;  // whose places are unknown; 1: none
};

// The views as they are, in the world of the boards. `data` is `rig` itself, which is kept as a
// reference.
PlacedViews views_of_world(const RigDataset& rig);
// A view for each board that a picture shows, in that board's frame. The instants of `data` have
// the first view of a picture.
PlacedViews views_of_boards(const RigDataset& rig);

// A rig as the solvers see it, and its state. All residuals are whitened to a noise of 1.
struct RigState {
  std::vector<Bundle> cameras;  // inliers of each camera's own calibration
  LinkedPoses poses;
  // By camera and view of its bundle.
  std::vector<std::vector<std::size_t>> index_of_view;  // index in the camera's data set
  std::vector<std::vector<OwnPose>> own;
  std::vector<std::vector<std::optional<std::size_t>>>
      instant;                   // in the data set; none: a view alone
  std::vector<double> noise_px;  // per coordinate, by camera
  std::vector<double> time;      // of the instants: s by the stamps, or their number without stamps
  double gap = 0;                // median between instants with views; 0: there are fewer than two
  std::vector<std::vector<double>> view_time;  // by camera and view: of its instant, or the stamp
  bool has_stamps = false;
  std::size_t num_instants = 0;                         // of the data set
  std::vector<std::shared_ptr<const HeldModels>> held;  // models that the bundles point to

  // The views of a camera's bundle at each instant of the data set.
  std::vector<std::vector<std::size_t>> views_at(std::size_t camera) const;
  // Takes a view out of its instant: from then on it only informs its camera's lens.
  void set_alone(std::size_t camera, std::size_t view);
};

// The state at the cameras' own calibrations, which are answers. Views without an instant are to be
// set alone. Of the poses only the links are set, those of the boards and of views that are alone.
RigState rig_state(const PlacedViews& rig, const std::vector<Calibration>& own, RigLenses lenses);

// Sets the times of all views to their stamps. Precondition: the rig has stamps.
void take_stamps(const RigDataset& rig, RigState& state);

// Estimates the own poses again, under the lenses and the board of the state: those of a camera
// with few pictures may have changed much. Of two poses that fit a view as well
// (policy::kAmbiguousCost) it takes the one at the rig's.
void update_own_poses(RigState& state);

// The half turn of the world that maps the points of the boards onto themselves, if their ids do
// not tell it: of one checkerboard or grid of circles.
std::optional<Pose> half_turn_of(const std::vector<PlacedBoard>& boards);

// Solves the bundle with the lenses held.
void solve_places(RigState& state, const CalibrateOptions& options);

// Exchanges the points of a view by the half turn.
void turn_view(RigState& state, std::size_t camera, std::size_t view, const Pose& half_turn);

// The squared whitened residuals of a view at the state of the rig, summed.
double cost_of_view(const RigState& state, std::size_t camera, std::size_t view);

}  // namespace tagcal::internal
