#pragma once

#include <optional>
#include <string>
#include <vector>

#include "python/arrays.hpp"
#include "tagcal/scene/dataset.hpp"
#include "tagcal/scene/rig.hpp"

namespace tagcal::python {

// The data set of OpenCV's lists: for each view an array of points, (N, 3), (N, 1, 3) or (1, N, 3),
// and one of pixels; or points (N, 3) that all views show. `images`: names, or none. Throws Error.
Dataset dataset_from_points(const ArrayLike& object_points, const ArrayLike& image_points,
                            const ArrayLike& size, const std::vector<std::string>& images);

using Names = std::optional<std::vector<std::string>>;
using TimesByCamera = std::optional<std::vector<std::vector<double>>>;

// The cameras of a rig, named cam0, cam1, .. without names, and their instants: `pair` is "name",
// "index" or "time". Throws Error.
RigDataset rig_dataset(const std::vector<Dataset>& datasets, const Names& names,
                       const std::string& pair, const TimesByCamera& times_s, double tolerance_s);

}  // namespace tagcal::python
