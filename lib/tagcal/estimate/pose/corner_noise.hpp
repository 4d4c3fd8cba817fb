#pragma once

#include <span>
#include <vector>

#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// How many of some corners have a covariance of their own.
struct CornerNoise {
  std::size_t num_known = 0;
  std::size_t num_corners = 0;

  void add(const View& view);
  // Whether covariances are worth counting with: where half of the corners and more have one.
  bool counts() const { return num_known > 0 && 2 * num_known >= num_corners; }
  std::size_t num_assumed() const { return num_corners - num_known; }
};

// A corner's own covariance; 0.5 px of noise where it has none.
Matrix2 covariance_or_assumed(const Observation& corner);

}  // namespace tagcal::internal
