#pragma once

#include <functional>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/detect/types.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

struct RefinedCorners {
  std::vector<View> views;  // those given, in their order
  int num_tags = 0;         // whole ones among them, in views whose picture is there
  int num_refined = 0;      // of these; the others stay as they were
};

// The corners of tags found before, fitted again in their pictures now that the lens is known
// (refine_tag.hpp): its bends need not be found from each tag, so that large tags and tags near the
// border say more, and what they claim is right. Where the tags of all pictures together show bends
// that the lens does not explain (paper that is not flat), these are fitted as without a lens.
// Pictures are known by name; the answer does not depend on the number of threads (0: one per
// core). `progress` as of detect_all(). Throws Error where a picture cannot be read or has another
// size than the camera's.
RefinedCorners refine_corners(const std::vector<ImageSource>& images,
                              const std::vector<PlacedBoard>& boards,
                              const std::vector<View>& views, const Camera& camera, int threads = 0,
                              const std::function<void(int, int)>& progress = {});

}  // namespace tagcal::internal
