#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tagcal/reproject/rectify.hpp"
#include "tagcal/reproject/types.hpp"

namespace tagcal::tools {

// camera.yaml, panorama.yaml or plane.yaml.
std::string target_file_name(const Target& target);

// Its content: a camera file that every --camera reads, or the keys of types.hpp. `poses`: of a
// plane in each picture; else one without a name.
using NamedPoses = std::vector<std::pair<std::string, Pose>>;
std::string target_yaml(const Target& target, const NamedPoses& camera_from_target,
                        const std::string& source_camera);

// The file of a rectified pair, as cv::FileStorage reads it: R1, R2, P1, P2 and Q of
// cv::stereoRectify, and the names of the cameras; of panoramas their resolution instead of P and
// Q.
std::string rectified_yaml(const RectifiedPair& pair, const std::array<std::string, 2>& names);

// "640x480 pixels, fx 512.31"
std::string described(const Target& target);

// A map as NumPy's .npy: float32, height x width x 2, the last axis x and y (what numpy.load gives
// to cv2.remap).
std::string map_npy(const PixelMap& map);

}  // namespace tagcal::tools
