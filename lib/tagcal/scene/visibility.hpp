#pragma once

#include "tagcal/scene/scene.hpp"

namespace tagcal {

// Where the corners of the scene are in a view, exactly: those in front of the camera and in its
// lens' domain, inside the image, on a face turned to the camera, and hidden neither by an occluder
// nor by the paper of another board. Points of a `points` target have no face and are seen from
// everywhere. Ordered by id.
std::vector<Observation> visible_corners(const Scene& scene, const Pose& camera_from_world);

}  // namespace tagcal
