#pragma once

#include "tagcal/io/yaml/yaml_reader.hpp"
#include "tagcal/scene/scene.hpp"

// Private to io: the camera of a scene (docs/reference/formats.md).

namespace tagcal::internal {

struct SceneCamera {
  Camera camera;
  std::string model;
  bool behind_window = false;  // the path gives the lens of each view
};

SceneCamera read_camera(const YamlValue& value);

}  // namespace tagcal::internal
