#pragma once

#include <apriltag/apriltag.h>

#include <memory>
#include <string_view>

// Private to detect: owning handles of the AprilTag library's objects.
namespace tagcal::internal {

struct FamilyDeleter {
  void (*destroy)(apriltag_family_t*) = nullptr;
  void operator()(apriltag_family_t* family) const { destroy(family); }
};
using FamilyHandle = std::unique_ptr<apriltag_family_t, FamilyDeleter>;

struct DetectorDeleter {
  void operator()(apriltag_detector_t* detector) const { apriltag_detector_destroy(detector); }
};
using DetectorHandle = std::unique_ptr<apriltag_detector_t, DetectorDeleter>;

struct DetectionsDeleter {
  void operator()(zarray_t* detections) const { apriltag_detections_destroy(detections); }
};
using DetectionsHandle = std::unique_ptr<zarray_t, DetectionsDeleter>;

// A new family with a border `border_bits` wide. Throws Error as tag_family() does.
FamilyHandle create_family(std::string_view name, int border_bits);

}  // namespace tagcal::internal
