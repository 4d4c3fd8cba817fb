#include "tagcal/estimate/bundle/projection_effect.hpp"

#include <algorithm>

#include "tagcal/estimate/projection_uncertainty.hpp"

namespace tagcal::internal {

MatrixX projection_effect(const UncertainLens& lens, const ImageSize& size) {
  const MatrixX projection =
      aligned_jacobian(lens, ImageGrid{size, 9, 7}.pixels(), kInfinitelyFar);  // numeric: samples
  return projection.transpose() * projection /
         static_cast<double>(std::max<Eigen::Index>(1, projection.rows()));
}

}  // namespace tagcal::internal
