#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tagcal/estimate/check_camera.hpp"

namespace tagcal::tools {

// What `tagcal check` says of the camera or rig in a file.
std::string check_text(const CameraCheck& check, const std::string& file, double limit_px);
nlohmann::ordered_json check_json(const CameraCheck& check);

}  // namespace tagcal::tools
