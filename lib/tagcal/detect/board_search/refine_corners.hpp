#pragma once

#include <functional>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/detect/types.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

struct RefinedCorners {
  std::vector<View> views;  // those given, in their order
  int num_tags = 0;         // tags with four corners, in views whose picture was found
  int num_refined = 0;      // tags that were refined; the others are unchanged
};

// Fits the corners of found tags again in their pictures, under a known lens (refine_tag.hpp).
// Bends need not be estimated from each tag then: large tags and tags near the border become more
// accurate, and their covariances correct. If all pictures together support bends that the lens
// does not explain (paper that is not flat), bends are fitted as well. Pictures are found by name.
// The answer does not depend on the number of threads (0: one per core). `progress` as in
// detect_all(). Throws Error if a picture cannot be read or its size is not the camera's.
RefinedCorners refine_corners(const std::vector<ImageSource>& images,
                              const std::vector<PlacedBoard>& boards,
                              const std::vector<View>& views, const Camera& camera, int threads = 0,
                              const std::function<void(int, int)>& progress = {});

}  // namespace tagcal::internal
