#pragma once

#include <string>

#include "tagcal/estimate/rig_types.hpp"

namespace tagcal::tools {

// Returns the report for a person: the verdict, findings, a row for each camera, the place of each
// camera in that of the reference, and how far the pairs can be trusted.
std::string rig_summary(const RigCalibration& rig, std::size_t reference);

// Returns one JSON object (docs/reference/formats.md).
std::string rig_json(const RigDataset& data, const RigCalibration& rig, std::size_t reference);

}  // namespace tagcal::tools
