#pragma once

#include "tagcal/io/types.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"

namespace tagcal::internal {

// Reads tagcal's own keys about the uncertainty of a camera that was read: sigmas, covariance,
// claim, findings, the seen region. Files of other programs have none of them.
void read_uncertainty(const YamlValue& top, CalibrationFile& file);

// The findings of a file of tagcal.
std::vector<Finding> read_findings(const YamlValue& top);

}  // namespace tagcal::internal
