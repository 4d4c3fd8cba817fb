#pragma once

#include "record.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal {

// Errors of a calibration's focal length and projection against what it claims, into the record:
// f_..., region_..., image_..., nodes_silent. What has no claim stays as it is.
void judge_lens(const Camera& truth, const Calibration& answer, Record& record);

}  // namespace tagcal
