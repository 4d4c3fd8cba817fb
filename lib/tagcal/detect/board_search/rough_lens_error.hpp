#pragma once

#include <Eigen/Core>
#include <optional>

#include "tagcal/detect/board_search/panel_lens.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"

// Private to detect.
namespace tagcal::internal {

// Covariance of (x0, y0, x1, y1, ..), px^2, that the uncertainty of a lens gives to corners fitted
// under it with bends. Homography and bends of second and third order absorb most of the lens'
// error; the rest at the corners counts. No value outside the lens' domain.
std::optional<Eigen::Matrix<double, 8, 8>> covariance_by_lens(const PanelLens& lens,
                                                              const Quad& corners);

// Displacement (x0, y0, x1, y1, ..), px, of corners fitted with bends under one lens if the other
// is the true one. No value outside the domain of either.
std::optional<Eigen::Matrix<double, 8, 1>> bias_between(const Lens& lens, const Lens& other,
                                                        const Quad& corners);

}  // namespace tagcal::internal
