#pragma once

#include <vector>

#include "fuzz/fuzz.hpp"
#include "tagcal/detect/detector.hpp"

// What the targets share that search pictures for boards.
namespace tagcal::fuzz {

inline Board board_of(int kind) {
  const Checkerboard checkerboard{
      .columns = 4, .rows = 3, .column_spacing = 0.1, .row_spacing = 0.1};
  switch (kind) {
    case 0:
      return make_board(AprilGrid{4, 3, 0.1, 0.3});
    case 1:
      return make_board(AprilGrid{2, 1, 0.1, 0.2, 0, "tag25h9", 1, false});
    case 2:
      return make_board(checkerboard);
    case 3:
      return make_board(AprilGrid{2, 2, 0.1, 1.3, 0, "tagStandard41h12", 1, false});
    default:
      return make_board(Charuco{5, 4, 0.1, 0.07, "DICT_4X4_50"});
  }
}

// The corners of a view in a picture of this size.
inline void check_view(const View& view, const ImageSize& size) {
  const double margin = 2.0;  // px: a corner may be extrapolated a little beyond the border
  for (const Observation& seen : view.observations) {
    require(seen.pixel.allFinite(), "corners are finite");
    require(seen.pixel.x() > -margin && seen.pixel.x() < size.width + margin &&
                seen.pixel.y() > -margin && seen.pixel.y() < size.height + margin,
            "corners are in the picture");
    if (!seen.covariance_px2) continue;
    require(seen.covariance_px2->allFinite(), "covariances are finite");
    require(seen.covariance_px2->determinant() > 0, "covariances are positive definite");
  }
}

}  // namespace tagcal::fuzz
