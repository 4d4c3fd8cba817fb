#pragma once

#include <string>

#include "tagcal/estimate/pose/pose_problem.hpp"

namespace tagcal::internal {

// What options cannot be meant; empty: they can.
std::string defect(const PoseOptions& options, std::size_t num_points);

// Why a problem has no answer; empty: it may have one.
std::string defect(const PoseProblem& problem);

}  // namespace tagcal::internal
