#include "tagcal/estimate/bundle/projection_effect.hpp"

#include <algorithm>

#include "tagcal/uncertainty/projection_uncertainty.hpp"

namespace tagcal::internal {

MatrixX projection_effect(const Model& model, const Camera& camera) {
  const MatrixX projection = aligned_jacobian(
      {&model, camera, {}}, ImageGrid{camera.image_size, 9, 7}.pixels(),  // numeric: samples
      kInfinitelyFar);
  return projection.transpose() * projection /
         static_cast<double>(std::max<Eigen::Index>(1, projection.rows()));
}

}  // namespace tagcal::internal
