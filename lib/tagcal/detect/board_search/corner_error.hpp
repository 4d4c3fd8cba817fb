#pragma once

#include <vector>

#include "tagcal/scene/dataset.hpp"

// Private to detect: the error of corners that no single fit can see.
namespace tagcal::internal {

struct ViewOfSize {
  View* view;
  ImageSize size;
};

// The error of corners that the fits leave out: prints that are not exact to their cells, pictures
// that a camera has sharpened, denoised or compressed. A standard deviation per coordinate, px; 0
// if the claims explain how corners scatter. It is seen where corners lie beside their neighbours
// of other tags, under the lens that the whole board of the picture shows; so errors that change
// smoothly over a board (its bend, the lens, rows that are read later) do not enter. One value for
// all views, which are of one camera. Boards with fewer than 24 corners in a view do not
// contribute.
double corner_error(const std::vector<ViewOfSize>& views, const std::vector<PlacedBoard>& boards);

// The same, and adds its square to the covariance of each corner.
double add_corner_error(const std::vector<ViewOfSize>& views,
                        const std::vector<PlacedBoard>& boards);

// How far corners scatter about their neighbours, in what their covariances claim: the sum of the
// normalised squares, halved, so that the mean is 1 if the claims hold.
struct ScatterNees {
  int num_corners = 0;
  double sum = 0;
};
ScatterNees scatter_nees(const std::vector<ViewOfSize>& views,
                         const std::vector<PlacedBoard>& boards);

// Adds an error of corners, px, to the covariances of observations that have one.
void widen_covariance(Observation& seen, double error_px);
void widen_covariances(View& view, double error_px);

}  // namespace tagcal::internal
