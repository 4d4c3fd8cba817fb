#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tagcal/estimate/types.hpp"

namespace tagcal {

// A view that was selected, and what it adds to those before it.
struct SelectedView {
  std::size_t view = 0;  // index in Dataset::views
  std::string image;
  int num_corners = 0;  // that took part in the calibration
  // Standard deviation of the projection at infinity (px per coordinate, RMS over the image) by
  // this view and those before it; infinite as long as they do not determine all parameters.
  double projection_px = 0;
};

struct ViewSelection {
  std::vector<SelectedView> views;  // in the order of selection
  double all_px = 0;                // the same standard deviation by all views
};

// Selects the `count` most informative views of a calibration (all of its views, if it has fewer):
// each next one is the view after which the projection at infinity has the least variance over the
// image, the measure of `advise`. Information is that of the corners with unknown poses, at the
// calibration's lens and poses and for its noise. Until the views determine all parameters, a
// millionth of the information of all views stands in for what is missing. Of equal views the first
// is taken: the answer does not depend on chance. Rejected views are not selected. Empty if the
// calibration has no covariance. `dataset`: the one that was calibrated; 1 <= count.
ViewSelection select_views(const Dataset& dataset, const Calibration& calibration, int count);

}  // namespace tagcal
