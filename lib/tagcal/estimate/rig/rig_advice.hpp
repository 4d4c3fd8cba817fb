#pragma once

#include <optional>
#include <vector>

#include "tagcal/estimate/rig/rig_report.hpp"

namespace tagcal::internal {

// The views of one board by cameras of two groups that are nearest in time.
struct NearestViews {
  std::size_t a = 0, b = 0;                  // cameras
  std::size_t instant_a = 0, instant_b = 0;  // in the data set
  double apart = 0;                          // in the unit of RigState::time
};
std::optional<NearestViews> nearest_views(const RigState& state,
                                          const std::vector<std::vector<std::size_t>>& groups);

// The pair of connected cameras, and the place before both, at which a board's projection is the
// least certain: nine parts of the first camera's image, at the smallest, the median and the
// largest distance of its boards. A view there is the most informative one for equal noise. No
// value if no two cameras see one place.
std::optional<AdvisedPair> advised_pair(const SolvedRig& solved);

}  // namespace tagcal::internal
