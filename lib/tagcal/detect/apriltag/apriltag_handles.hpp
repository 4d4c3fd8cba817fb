#pragma once

#include <apriltag/apriltag.h>

#include <memory>
#include <string>
#include <string_view>

// Private to detect: owning handles of the AprilTag library's objects.
namespace tagcal::internal {

// numeric: limits of AprilTag 3.3.0, px. It crashes on pictures of 2x2 px and smaller, of one row,
// and of 5x3 px if decimated: pictures with a shorter side are not searched. It ends the program
// from 32768 px on: pictures with a longer side are searched at half their size and less only.
constexpr int kMinPictureSidePx = 8;
constexpr int kMaxPictureSidePx = 32767;

// Frees the decoding table too, which AprilTag does together with a detector only.
struct FamilyDeleter {
  void (*destroy)(apriltag_family_t*) = nullptr;
  void operator()(apriltag_family_t* family) const {
    if (family->impl) {
      apriltag_detector_t* owner = apriltag_detector_create();
      apriltag_detector_add_family(owner, family);
      apriltag_detector_destroy(owner);
    }
    destroy(family);
  }
};
using FamilyHandle = std::unique_ptr<apriltag_family_t, FamilyDeleter>;

// Leaves the decoding tables of the detector's families alone: others may use them.
struct DetectorDeleter {
  void operator()(apriltag_detector_t* detector) const {
    zarray_clear(detector->tag_families);
    apriltag_detector_destroy(detector);
  }
};
using DetectorHandle = std::unique_ptr<apriltag_detector_t, DetectorDeleter>;

struct DetectionsDeleter {
  void operator()(zarray_t* detections) const { apriltag_detections_destroy(detections); }
};
using DetectionsHandle = std::unique_ptr<zarray_t, DetectionsDeleter>;

// A new family with a border `border_bits` wide. Throws Error as tag_family() does.
FamilyHandle create_family(std::string_view name, int border_bits);

// A family and its decoding table for tags with up to `max_hamming` wrong bits. Detectors of
// several threads may share it: the table of tagCircle49h12 takes 157 MB and most of a second.
// Creates it if it is neither in use nor one of the two that were used last. Throws Error as
// tag_family() does.
std::shared_ptr<apriltag_family_t> shared_family(const std::string& name, int border_bits,
                                                 int max_hamming);

}  // namespace tagcal::internal
