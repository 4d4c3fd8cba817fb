#pragma once

#include <Eigen/Core>
#include <vector>

#include "tagcal/scene/image.hpp"

// Private to detect: the grey levels of a tag's cells in a picture.
namespace tagcal::internal {

// Row by row, `width` x `width` cells about the origin of `pixels`, the homography from cells to
// pixels.
// The level of each cell: mean of four samples `spread` from its centre, or at its centre for 0.
// The samples are placed by the homography's derivative at the centre.
std::vector<double> cell_levels(const ImageView8& image, const Eigen::Matrix3d& pixels, int width,
                                double spread);

}  // namespace tagcal::internal
