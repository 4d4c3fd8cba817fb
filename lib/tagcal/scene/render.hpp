#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "tagcal/scene/board.hpp"
#include "tagcal/scene/image.hpp"
#include "tagcal/scene/scene.hpp"

namespace tagcal {

// The families whose tags a scene shows, by name.
using TagFamilies = std::map<std::string, TagFamily>;

// The light on the sensor before noise, as levels in [0, 1] times the exposure. Each surface counts
// with the exact area of the pixel in which it is seen, also where surfaces cut each other (edges
// that the lens bends are followed to 1e-4 px). The blur is a continuous Gaussian, applied before
// the pixels sample it. Throws Error for an unknown family or tag id, and if the ink would spread
// over the paper's border or until edges meet (ink_cells).
ImageF render_light(const Scene& scene, const TagFamilies& families, const Pose& camera_from_world);

// Applies the sensor's gamma, noise, clipping and rounding. Equal seeds give equal bytes. The
// caller chooses between the two functions by `sensor.bits`.
Image8 expose(const ImageF& light, const Sensor& sensor, std::uint64_t seed);

// The same with 16 bits: white is 65535, and the standard deviation of the noise is
// 257 * noise_levels.
Image16 expose16(const ImageF& light, const Sensor& sensor, std::uint64_t seed);

}  // namespace tagcal
