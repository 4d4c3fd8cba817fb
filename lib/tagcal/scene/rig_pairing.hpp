#pragma once

#include <vector>

#include "tagcal/scene/rig.hpp"

// Which views of the cameras of a rig belong together. Every view is in exactly one instant, also
// one that no other camera has a view for. All functions throw Error for no cameras.

namespace tagcal {

// By the names of the pictures, without folder and ending. Names need not be equal if they differ
// in one number or word that is the camera's own: frame003-camera0 and frame003-camera1, left01 and
// right01. The instants are sorted by name; numbers count by value. Throws Error if two pictures of
// a camera have one name, if no two cameras have a name in common, and if more than one part of the
// names could be the camera's own.
std::vector<Instant> pair_by_name(const std::vector<RigCamera>& cameras);

// View i of each camera. The views must be those of all pictures, also of pictures in which nothing
// was seen. Throws Error if the cameras do not have equally many.
std::vector<Instant> pair_by_index(const std::vector<RigCamera>& cameras);

// By time stamps that differ by at most `tolerance_s`. Two views are paired if each is the nearest
// one to the other, so that no view is in two instants. The instants are in the order of time.
// Throws Error for a camera without stamps, stamps that are not finite or do not increase from view
// to view, and a tolerance that is negative or not finite.
std::vector<Instant> pair_by_time(const std::vector<RigCamera>& cameras, double tolerance_s);

}  // namespace tagcal
