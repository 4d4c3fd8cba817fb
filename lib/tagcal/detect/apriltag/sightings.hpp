#pragma once

#include <vector>

#include "tagcal/detect/apriltag/apriltag_handles.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal::internal {

// A tag that AprilTag read.
struct Sighting {
  const apriltag_family_t* family = nullptr;
  int id = 0;
  int hamming = 0;  // number of wrong bits
  Quad corners;     // pixel centres at whole numbers
};

// The tags of a detector's families in a picture whose black is first shrunk by `shrink` px; their
// corners are moved back. Those whose corners are no face of a tag are left out.
std::vector<Sighting> sightings(apriltag_detector_t& detector, const ImageView8& image, int shrink);

// Returns true if two sightings of one id are of one tag.
bool are_one_tag(const Quad& a, const Quad& b);

}  // namespace tagcal::internal
