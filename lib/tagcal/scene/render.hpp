#pragma once

#include <cstdint>

#include "tagcal/scene/board.hpp"
#include "tagcal/scene/image.hpp"
#include "tagcal/scene/scene.hpp"

namespace tagcal {

// The light on the sensor before noise, as levels in [0, 1] times the exposure. Each surface counts
// with the exact area of the pixel in which it is seen, also where surfaces cut each other (edges
// that the lens bends are followed to 1e-4 px). The blur is a continuous Gaussian, applied before
// the pixels sample it. Light on the sheets, vignetting and depth of field as the scene says; the
// shading by a point lamp is that at the centre of a pixel. A line of a rolling shutter is that
// line of the picture from its own pose. Throws Error for an unknown family or tag id, and if the
// ink would spread over the paper's border or until edges meet (ink_cells), and as check_sensor.
ImageF render_light(const Scene& scene, const TagFamilies& families, const Pose& camera_from_world);

// Throws Error if the camera cannot have the sensor's settings: vignetting that is negative in the
// image or needs rays below 90 degrees to the axis, a focus without a perspective lens or with a
// rolling shutter; and for a mosaic, denoising, sharpening or JPEG quality out of its range, or
// JPEG of 16 bits.
void check_sensor(const Camera& camera, const Sensor& sensor);

// The depth of what the centre of each pixel sees: z in the camera, metres; NaN for nothing. The
// camera is that of the pixel's line.
ImageF render_depth(const Scene& scene, const Pose& camera_from_world);

// The depths as whole multiples of a unit, rounded; 0 for nothing, and for a depth that is not
// between 1 and 65535 units: `num_beyond` (may be null) counts those.
Image16 depth_levels(const ImageF& depth, double unit_m, std::size_t* num_beyond);

// Applies the sensor's gamma, noise, processing, clipping and rounding. Equal seeds give equal
// bytes. The caller chooses between the two functions by `sensor.bits`. Throws Error as
// check_sensor for processing.
Image8 expose(const ImageF& light, const Sensor& sensor, std::uint64_t seed);

// The same with 16 bits: white is 65535, and the standard deviation of the noise is
// 257 * noise_levels.
Image16 expose16(const ImageF& light, const Sensor& sensor, std::uint64_t seed);

}  // namespace tagcal
