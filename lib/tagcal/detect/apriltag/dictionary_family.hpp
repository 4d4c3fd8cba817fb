#pragma once

#include <string_view>

#include "tagcal/detect/apriltag/apriltag_handles.hpp"

// Private to detect.
namespace tagcal::internal {

// The markers of OpenCV's dictionary as a family of the AprilTag library, with a border one cell
// wide: its detector then reads them. Empty if OpenCV has no dictionary of this name.
FamilyHandle create_dictionary_family(std::string_view name);

}  // namespace tagcal::internal
