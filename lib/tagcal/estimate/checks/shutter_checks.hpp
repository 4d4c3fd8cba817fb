#pragma once

#include <optional>
#include <vector>

#include "tagcal/estimate/checks/evidence.hpp"
#include "tagcal/estimate/findings.hpp"

namespace tagcal::internal {

// Rows of the pictures that are displaced against one another, of a bundle without velocities.
std::optional<Finding> check_rows(const Bundle& bundle);
// A camera that moved while a rolling shutter read the rows.
std::optional<Finding> check_shutter(const Bundle& bundle, const CalibrateOptions& options);
// Times of the views, if there are some, that do not show how long the rows take.
std::optional<Finding> check_readout(const std::optional<Readout>& readout,
                                     const std::vector<double>& times_s);

}  // namespace tagcal::internal
