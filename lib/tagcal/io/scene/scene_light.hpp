#pragma once

#include "tagcal/io/yaml/yaml_reader.hpp"
#include "tagcal/scene/scene.hpp"

// Private to io: the light of a scene and what the sensor makes of it (docs/reference/formats.md).

namespace tagcal::internal {

// Its key `frame` is left to the caller.
Light read_light(const YamlValue& value);

// Throws also if the camera cannot have such a sensor.
Sensor read_sensor(const YamlValue& value, const Camera& camera);

}  // namespace tagcal::internal
