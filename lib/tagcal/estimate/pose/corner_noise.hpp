#pragma once

#include <cstddef>

#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// Counts the corners that have a covariance of their own.
struct CornerNoise {
  std::size_t num_known = 0;
  std::size_t num_corners = 0;

  void add(const View& view);
  // True if half of the corners or more have a covariance: then the estimate uses them.
  bool counts() const { return num_known > 0 && 2 * num_known >= num_corners; }
  std::size_t num_assumed() const { return num_corners - num_known; }
};

// Returns a corner's own covariance, or that of policy::kAssumedSigmaPx.
Matrix2 covariance_or_assumed(const Observation& corner);

}  // namespace tagcal::internal
