#pragma once

#include <Eigen/Core>
#include <map>
#include <utility>
#include <vector>

#include "tagcal/scene/board.hpp"

// Private to detect.
namespace tagcal::internal {

// Blobs that form a lattice in the picture, by the coefficients of two of its shortest vectors.
using CircleLattice = std::map<std::pair<int, int>, Eigen::Vector2d>;

// The lattice that grows from a blob and its nearest neighbours: each further blob lies where its
// neighbours in the lattice predict it. Empty if the blob has no two independent neighbours.
CircleLattice grow_lattice(const std::vector<Eigen::Vector2d>& blobs, std::size_t seed);

// A grid's centres of gravity, by id.
using CirclePlaces = std::map<int, Eigen::Vector2d>;

// The grid's discs in a lattice: seen from the front, with each outermost row and column seen to a
// third, and more than half of all. Of several, the one whose y axis points up most in the picture.
// Empty if the lattice is not this grid.
CirclePlaces places_in_lattice(const CircleGrid& grid, const CircleLattice& lattice);

}  // namespace tagcal::internal
