#pragma once

#include <string>
#include <vector>

#include "tagcal/detect/apriltag/family_detector.hpp"
#include "tagcal/detect/types.hpp"

// Private to detect.
namespace tagcal::internal {

struct TagsOfKind {
  TagKind kind;
  std::vector<FoundTag> tags;  // at most one at a place; the corners are those of their edges
};

struct KindsInPicture {
  int quads = 0;                  // shapes with four sides      , tags or not
  std::vector<TagsOfKind> kinds;  // of which there are tags
};

// The tags of some families and borders, in one search for all of them. Tags of other kinds may be
// read as some of these (is_sure tells).
KindsInPicture search_kinds(const ImageView8& image, const std::vector<TagKind>& wanted);

// All kinds that the library knows.
std::vector<TagKind> all_kinds();

}  // namespace tagcal::internal
