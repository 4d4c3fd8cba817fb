#pragma once

#include <string>
#include <vector>

#include "python/arrays.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::python {

// The data set of OpenCV's lists: for each view an array of points, (N, 3), (N, 1, 3) or (1, N, 3),
// and one of pixels; or points (N, 3) that all views show. `images`: names, or none. Throws Error.
Dataset dataset_from_points(const ArrayLike& object_points, const ArrayLike& image_points,
                            const ArrayLike& size, const std::vector<std::string>& images);

}  // namespace tagcal::python
