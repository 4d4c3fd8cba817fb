#pragma once

#include "tagcal/estimate/types.hpp"

namespace tagcal::internal {

// The matrix E for which trace(E C), with the covariance C of the model's free parameters, is the
// variance of the projection at infinity, per coordinate, as the mean over the image: the measure
// by which views are advised and selected.
MatrixX projection_effect(const Model& model, const Camera& camera);

}  // namespace tagcal::internal
