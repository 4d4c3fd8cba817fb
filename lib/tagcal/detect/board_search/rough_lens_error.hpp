#pragma once

#include <Eigen/Core>
#include <optional>

#include "tagcal/detect/board_search/panel_lens.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"

// Private to detect.
namespace tagcal::internal {

// What a lens that is not known exactly does to corners fitted under it with bends: the covariance
// of (x0, y0, x1, y1, ..), px^2. A homography and bends of second and third order take most of the
// lens' error; what they leave of it at the corners is counted. No value where the lens ends.
std::optional<Eigen::Matrix<double, 8, 8>> covariance_by_lens(const PanelLens& lens,
                                                              const Quad& corners);

// How much one lens moves corners fitted with bends under another: (x0, y0, x1, y1, ..), px.
std::optional<Eigen::Matrix<double, 8, 1>> bias_between(const Lens& lens, const Lens& other,
                                                        const Quad& corners);

}  // namespace tagcal::internal
