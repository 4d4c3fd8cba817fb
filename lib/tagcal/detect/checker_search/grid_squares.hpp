#pragma once

#include "tagcal/detect/checker_search/junction_grid.hpp"
#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal::internal {

// True if the squares between the junctions of a grid are those of a checkerboard: most are there,
// they are black and white in turn, each has one level, and the next ones of its colour have it
// too. Junctions of noise and textures look alike but are not joined by such squares. A single
// square has none to be compared with and passes.
bool shows_squares(const ImageView8& image, const JunctionGrid& grid);

}  // namespace tagcal::internal
