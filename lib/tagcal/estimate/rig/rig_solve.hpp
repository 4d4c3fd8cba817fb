#pragma once

#include <string>
#include <vector>

#include "tagcal/estimate/rig/rig_checks.hpp"

namespace tagcal::internal {

// Takes the views of cameras that moved out of their instants, on the shorter side of the move, and
// starts those cameras again from the rest.
std::vector<CameraMove> separate_moves(RigState& state, const RigStart& start);

// The cost of the rig to a view: its squares under the rig, less those at its own pose.
struct ViewExcess {
  std::size_t camera = 0, view = 0;
  double square = 0;
  double of_noise = 0;  // what the noise of the poses makes of it, on average
  int num_corners = 0;
};

// Those of the views whose instant has another view.
std::vector<ViewExcess> excesses(const RigState& state);

// The RMS of the excess of a camera's views beyond that of noise, over the noise of a coordinate.
double excess_of_camera(const std::vector<ViewExcess>& all, std::size_t camera);

// The cost of the rig over its degrees of freedom: 1 if the poses of the views contradict it by
// their noise only, more if lenses or cameras are not as they are modelled (Birge, Phys. Rev. 40,
// 207 (1932)). At least 1.
double strain_of_rig(const RigState& state, Eigen::Index num_extrinsics);

// Solves the bundle, and takes the instants out that contradict the rig (the worst view of an
// instant of three views or more), in turn until none does.
struct RigSolution {
  BundleSummary summary;
  int num_iterations = 0;
  std::vector<std::size_t> rejected;  // instants of the data set, ascending
  std::vector<int> num_rejected;      // views, by camera
};
RigSolution solve_robustly(RigState& state, const CalibrateOptions& options);

}  // namespace tagcal::internal
