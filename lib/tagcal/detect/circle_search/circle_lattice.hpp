#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <vector>

#include "tagcal/detect/opencv/circle_blobs.hpp"
#include "tagcal/scene/board.hpp"

// Private to detect.
namespace tagcal::internal {

// A grid's centres of gravity, by id.
using CirclePlaces = std::map<int, Eigen::Vector2d>;

// A grid's discs among the blobs of a picture: the first lattice that shows them from the front,
// each outermost row and column to a third, and more than half of all, few of them near a
// perspective image of the grid. Empty if none does.
CirclePlaces places_among(const std::vector<CircleBlob>& blobs, const CircleGrid& grid);

// The grid whose discs are the largest lattice among the blobs; its spacing is 1. No value if the
// lattice fills no grid.
std::optional<CircleGrid> whole_grid_among(const std::vector<CircleBlob>& blobs);

}  // namespace tagcal::internal
