#pragma once

#include <optional>
#include <vector>

#include "tagcal/estimate/camera_check/change_test.hpp"

namespace tagcal::internal {

// A kind of change of one camera: a basis of the parameters of the check, and the pixels that it
// moves.
struct PossibleChange {
  std::size_t camera = 0;
  ChangeKind kind = ChangeKind::lens;
  Eigen::MatrixXd basis;
  Eigen::MatrixXd pixels;  // two rows a sample, by the coefficients of the basis
};

// The kinds of change of the cameras of a fit, by its parameters (`size`: their number, with the
// board's shape), the leanest first.
std::vector<PossibleChange> candidates_of(const FreeFit& fit, Eigen::Index size);

// The leanest kind whose rest is not significant; of several with as many parameters the one that
// leaves least. No value if none is.
std::optional<CameraChange> leanest_change(const std::vector<PossibleChange>& candidates,
                                           const ChangeTest& test, const FreeFit& fit);

// The smallest change of a kind that the pictures would have shown.
DetectableChange detectable(const PossibleChange& candidate, const ChangeTest& test,
                            const FreeFit& fit);

}  // namespace tagcal::internal
