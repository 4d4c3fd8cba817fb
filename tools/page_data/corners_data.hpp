#pragma once

#include "page_data/json_values.hpp"
#include "page_data/page_content.hpp"

namespace tagcal::tools {

// A corner of a view of the data set, with its residual (observed - reprojected).
struct PageCorner {
  std::size_t view = 0;
  CornerId id;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d residual_px = Eigen::Vector2d::Zero();  // NaN: not known
  bool rejected = false;
  double sd_px = 0;  // claimed, per coordinate; NaN: not known
};

// All corners of all views, in the order of the data set.
std::vector<PageCorner> page_corners(const PageContent& content);

// Columns of equal length.
PageJson corners_json(const std::vector<PageCorner>& corners);

}  // namespace tagcal::tools
