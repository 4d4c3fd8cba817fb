#pragma once

#include <string>

#include "tagcal/estimate/pose/pose_problem.hpp"

namespace tagcal::internal {

// Describes an invalid option; empty if all are valid.
std::string defect(const PoseOptions& options, std::size_t num_points);

// Describes why a problem has no answer; empty if it may have one.
std::string defect(const PoseProblem& problem);

}  // namespace tagcal::internal
