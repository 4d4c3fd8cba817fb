#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/scene/rig.hpp"

namespace tagcal::python {

using Names = std::optional<std::vector<std::string>>;
using Times = std::optional<std::vector<std::vector<double>>>;

// The cameras of a rig, named cam0, cam1, .. without names, and their instants: `pair` is "name",
// "index" or "time". Throws Error.
RigDataset rig_dataset(const std::vector<Dataset>& datasets, const Names& names,
                       const std::string& pair, const Times& times_s, double tolerance_s);

}  // namespace tagcal::python
