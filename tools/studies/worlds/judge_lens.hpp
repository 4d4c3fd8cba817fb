#pragma once

#include "record.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal {

// Compares a calibration's focal length and projection with the truth, in units of the claimed
// standard deviations. Fills f_..., region_..., image_... and nodes_silent of the record; what is
// not claimed keeps its value.
void judge_lens(const Camera& truth, const Calibration& answer, Record& record);

}  // namespace tagcal
