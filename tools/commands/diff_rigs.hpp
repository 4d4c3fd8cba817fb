#pragma once

#include <optional>
#include <string>

#include "report/rig_comparison.hpp"

// `tagcal diff` of two rigs.

namespace tagcal::tools {

// The rig of an argument; no value if it names one camera. Prints what reading changed.
std::optional<ComparedRig> rig_of_argument(const std::string& file_and_name);

struct RigDifferenceAnswer {
  std::string text;  // or JSON
  std::optional<CheckVerdict> verdict;
};

// The lenses are compared far away and at the distance, over the regions of the corners or the
// whole images. `limit_px`: the change that matters (change_verdict).
RigDifferenceAnswer rig_difference(const ComparedRig& a, const ComparedRig& b, double near_m,
                                   bool whole_image, double limit_px, bool as_json);

}  // namespace tagcal::tools
