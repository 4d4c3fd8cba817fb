#pragma once

#include <optional>
#include <vector>

#include "tagcal/estimate/check_types.hpp"
#include "tagcal/estimate/rig/rig_covariance.hpp"
#include "tagcal/scene/rig.hpp"
#include "tagcal/uncertainty/known_rig.hpp"

namespace tagcal::internal {

// The cameras of a check, free about what is known of them: lenses, places and the board's shape
// by the pictures alone, but for priors that keep what these do not determine near the known
// cameras. All residuals are whitened to a noise of 1, which they show themselves.
struct FreeFit {
  RigState state;
  Connected connected;
  double freedom = 0;  // of the residuals
  std::vector<CheckedCamera> cameras;
  // By camera: the RMS of the residuals that the rig's common poses leave, as a multiple of
  // CheckedCamera::known_rms_px.
  std::vector<double> strain;
};

// Fits robustly: corners beyond policy::kOutlierSigmas of the free camera are rejected, not those
// of the known one, because a change would reject what shows it. Adds findings about views that
// are not used. No value if no view determines its pose.
std::optional<FreeFit> fit_freely(const RigDataset& data, const KnownRig& known,
                                  const CheckOptions& options, std::vector<Finding>& findings);

}  // namespace tagcal::internal
