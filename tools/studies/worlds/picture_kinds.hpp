#pragma once

#include <string>
#include <vector>

#include "tagcal/random.hpp"
#include "tagcal/scene/scene.hpp"

// What cameras do to their pictures in worlds with the defect `camera`: one kind a world.

namespace tagcal {

std::vector<std::string> picture_kinds();

// Changes the scene's sensor, or its print, to pictures of the kind, or of one that is drawn
// uniformly from those that suit the lens if `kind` is empty. Returns the kind, "" if it does not
// suit the lens. Precondition: the scene has explicit poses and one AprilGrid.
std::string draw_pictures(const std::string& kind, Scene& scene, Random& random);

}  // namespace tagcal
