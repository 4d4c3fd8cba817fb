#pragma once

#include <string>
#include <vector>

#include "tagcal/io/types.hpp"

namespace tagcal::internal {

// Times of poses for formats of trajectories, in seconds, as decimal numbers without a sign: those
// that the poses have, to a microsecond; else the names of their pictures if these are numbers (16
// digits and more: nanoseconds); else 0, 1, 2, ..
struct PoseTimes {
  std::vector<std::string> seconds;  // one for each pose, all different
  std::string note;                  // where they come from
};

PoseTimes times_of(const std::vector<ImagePose>& poses);

}  // namespace tagcal::internal
