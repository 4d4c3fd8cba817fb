#pragma once

#include <string>

#include "tagcal/estimate/types.hpp"

namespace tagcal::python {

// The text of an estimate without an answer: its status and the sentence of its refusal.
std::string refusal(Status status, const std::vector<Finding>& findings);

// "; 2 warnings", or nothing.
std::string warnings_text(const std::vector<Finding>& findings);

// The options of the poses of views, checked. Throws Error.
PoseOptions pose_options(double sigma_px, bool reject_outliers, int max_iterations,
                         std::uint64_t seed);

}  // namespace tagcal::python
