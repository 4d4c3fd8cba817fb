#pragma once

#include "tagcal/io/formats/lens_numbers.hpp"

// transforms.json of nerfstudio and instant-ngp: a lens, and a pose per picture of a camera that
// looks along -z with y up (OpenGL).

namespace tagcal::internal {

bool has_nerfstudio_keys(const YamlValue& top);
// `stated`: the size of the pictures if the file has none; 0 x 0: not known.
CameraFile read_nerfstudio(const YamlValue& top, const ImageSize& stated);
FormatOutput write_nerfstudio(const CameraFile& file);

}  // namespace tagcal::internal
