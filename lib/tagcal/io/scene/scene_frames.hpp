#pragma once

#include <vector>

#include "tagcal/io/yaml/yaml_reader.hpp"
#include "tagcal/scene/moving_scene.hpp"

// Private to io: frames, their motion, and the placement of parts on them
// (docs/reference/formats.md).

namespace tagcal::internal {

// A placement: a pose as read_pose reads it, or one given by angles, by an axis and an angle, by a
// look-at, an orbit or an aircraft, or by a list of elementary steps.
Affine read_placement(const YamlValue& value);
Pose read_rigid_placement(const YamlValue& value);  // throws if it scales

// The frames of a scene, with their motion. Throws unless they are a tree under the world.
std::vector<MovingFrame> read_frames(const YamlValue& top);

// The name of an existing frame under the key `frame`, or the world.
std::string read_frame_of(const YamlValue& part, const std::vector<MovingFrame>& frames);

}  // namespace tagcal::internal
