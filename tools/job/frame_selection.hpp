#pragma once

#include <string>

#include "job/calibration_job.hpp"

namespace tagcal::tools {

// Throws Error if the job asks for something of chosen frames, but the input has none.
void check_frame_options(const CalibrationJob& job, const Input& input);

// Keeps the views of the frames that add most (choose_frames), counts what became of the others,
// says so, and fills the folder `keep`, if there is one.
void take_chosen_frames(const CalibrationJob& job, const CalibrateOptions& options, Input& input);

// "1500 frames: 812 looked at, 810 with board, 40 fast, 670 add nothing, 100 used"
std::string tally_text(const FrameTally& tally);

}  // namespace tagcal::tools
