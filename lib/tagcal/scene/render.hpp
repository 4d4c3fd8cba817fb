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

// What the sensor would see, as levels in [0, 1] times the exposure, before noise: the share of
// each pixel's square that every surface covers is its exact area (edges bent by the lens are
// followed to 1e-4 px), and the blur is that of a continuous Gaussian before the pixels sample it.
// Throws Error where a family, or a tag's id in it, is not known, and where the ink would spread
// over the paper's border or until edges meet (ink_cells).
ImageF render_light(const Scene& scene, const TagFamilies& families, const Pose& camera_from_world);

// The sensor's gamma, its noise, rounding and clipping. Equal seeds give equal bytes. `sensor.bits`
// is what the caller chooses between the two by.
Image8 expose(const ImageF& light, const Sensor& sensor, std::uint64_t seed);

// The same, noise included, on a scale 257 times as fine: white is 65535, and noise of
// `noise_levels` (8-bit levels) has a standard deviation of 257 * noise_levels.
Image16 expose16(const ImageF& light, const Sensor& sensor, std::uint64_t seed);

}  // namespace tagcal
