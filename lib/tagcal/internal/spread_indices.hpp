#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace tagcal::internal {

// At most `count` of the indices below n, evenly spread, ascending.
inline std::vector<std::size_t> spread_indices(std::size_t n, std::size_t count) {
  std::vector<std::size_t> indices(std::min(n, count));
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = i * n / indices.size();
  return indices;
}

}  // namespace tagcal::internal
