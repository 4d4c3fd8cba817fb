#pragma once

#include <string>
#include <vector>

#include "tagcal/estimate/handeye.hpp"

namespace tagcal::tools {

// The poses of a file that `tagcal pose --json` wrote (docs/tasks/pose.md), without those of the
// robot: views without an answer have none, ambiguous ones two. Throws Error, with the key: another
// file, a pose without a covariance.
std::vector<HandeyeView> read_pose_file(const std::string& file);

}  // namespace tagcal::tools
