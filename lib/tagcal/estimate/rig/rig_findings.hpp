#pragma once

#include <vector>

#include "tagcal/estimate/rig/rig_solve.hpp"

// The findings of a rig: each function adds its own to the answer.

namespace tagcal::internal {

// True for a finding of a rolling shutter.
bool is_of_shutter(const Finding& finding);
// Cameras whose own pictures give no answer: then the rig has none.
void report_unanswered(RigLenses lenses, RigCalibration& answer);
// Repeats the findings of cameras whose lenses were given, and those of shutters.
void report_cameras(bool are_known, RigCalibration& answer);
// By its `groups`: names the two views that are nearest to a common instant, and sets `next`.
void report_groups(const RigDataset& rig, const RigState& state, RigCalibration& answer);
void report_turned(const RigStart& start, RigCalibration& answer);
void report_shifts(const RigDataset& rig, const RigStart& start, RigCalibration& answer);
// By its `clocks`. `tells_offset`: the instants are near enough to one another for a number.
void report_clocks(const RigDataset& rig, bool corrected, bool tells_offset,
                   RigCalibration& answer);
void report_moves(const RigDataset& rig, const std::vector<CameraMove>& moves,
                  RigCalibration& answer);

// The rig contradicts a camera: more than a third of its instants are rejected, or the rig moves
// its corners by policy::kOutlierSigmas of their noise. From the noise on it says so.
void report_contradictions(const RigDataset& rig, const RigState& state,
                           const RigSolution& solution, RigCalibration& answer);

// Cameras whose place is unknown: by more than a tenth of the distance of the boards, or of a
// radian, as a focal length is refused.
void report_unobservable(const RigState& state, RigCalibration& answer);

}  // namespace tagcal::internal
