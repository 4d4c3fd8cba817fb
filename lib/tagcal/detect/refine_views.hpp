#pragma once

#include <functional>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/detect/types.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal {

struct RefinedViews {
  std::vector<View> views;  // those of the data set, in their order
  // In views whose picture was found: tags with four corners, and corners of checkerboards and
  // ChArUco boards and centres of circles. Those that were not refined are unchanged.
  int num_tags = 0, num_refined_tags = 0;
  int num_corners = 0, num_refined_corners = 0;
  double corner_error_px = 0;  // as in DetectedPicture
};

// Fits the corners of found views again in their pictures under a known lens, that of a first
// calibration for example. Bends need not be estimated from each tag or corner then: large tags and
// tags near the border become more accurate, and their covariances correct. If all pictures
// together support bends that the lens does not explain (paper that is not flat), bends of tags are
// fitted as well. Pictures are found by name. The answer does not depend on the number of threads
// (0: one per core). `progress` as in detect_all(). Throws Error if a picture cannot be read or its
// size is not the camera's.
RefinedViews refine_views(const Dataset& found, const std::vector<ImageSource>& images,
                          const Camera& camera, int threads = 0,
                          const std::function<void(int, int)>& progress = {});

}  // namespace tagcal
