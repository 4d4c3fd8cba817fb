#pragma once

#include <Eigen/Core>
#include <span>

#include "tagcal/detect/refine.hpp"
#include "tagcal/detect/tag_fit/picture_processing.hpp"

// Private to detect.
namespace tagcal::internal {

// The lines between the cells of the tags as they were printed: programs that draw tags in pixels
// (OpenCV's functions for markers and boards) round them to whole pixels.
struct PrintedLines {
  Eigen::VectorXd inner;  // within a tag, in sides from its upper-left corner; empty: equal cells

  bool is_none() const { return inner.size() == 0; }
  // The pattern with these lines, if it has as many.
  TagPattern printed(TagPattern pattern) const;
};

// Estimates the lines from some tags of a picture, from `start` on. None if equal cells are not
// clearly worse.
PrintedLines printed_lines_of_picture(const ImageView8& image, std::span<const TagInPicture> tags,
                                      const CameraProcessing& processing,
                                      const PrintedLines& start = {});

}  // namespace tagcal::internal
