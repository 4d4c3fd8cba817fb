#pragma once

#include "tagcal/io/yaml/yaml_reader.hpp"
#include "tagcal/scene/scene.hpp"

// Private to io: the path of a scene's camera, and single viewpoints (docs/reference/formats.md).

namespace tagcal::internal {

// The path. Its key `frame` is left to the caller.
CameraPath read_path(const YamlValue& value, const ImageSize& image_size);

// The number of views under `views`. A path that lists poses has as many, one that may stand still
// has one view unless the file says otherwise.
int read_num_views(const YamlValue& top, const CameraPath& path);

// The placement parent_from_frame by the keys of a path: a camera's axes for look_at and orbit, an
// aircraft's for aircraft.
Pose read_viewpoint(std::string_view kind, const YamlValue& value);

}  // namespace tagcal::internal
