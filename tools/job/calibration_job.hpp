#pragma once

#include <optional>
#include <string>

#include "job/input.hpp"
#include "job/shutter.hpp"
#include "tagcal/estimate/advice.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal::tools {

// One data set to calibrate.
struct CalibrationJob {
  InputArguments input;
  CalibrateOptions options;
  bool advise = false;
  int select = 0;  // number of views to keep; 0: all
  // Of the frames of a video or bag (--frames auto): the goal of the choice, the sd of the
  // projection at infinity (0: until a frame adds next to nothing); a line for each; a folder for
  // those used.
  double until_px = 0;
  bool explains_frames = false;
  std::string keep;
  Shutter shutter = Shutter::automatic;
  bool refine_corners = false;  // fit them again under the first lens, and calibrate again
  int threads = 0;              // of detection and solver; 0: one per core
  bool shows_progress = true;   // on stderr
};

// Wall-clock times of the command, beside those in CalibrateSeconds.
struct CommandSeconds {
  double read = 0;    // files and detection
  double refine = 0;  // corners fitted again
  double write = 0;   // files, pictures, the page
  double total = 0;
};

struct CalibrationAnswer {
  Calibration calibration;  // with findings about the input
  std::optional<AdvisedView> advice;
  std::optional<ViewSelection> selection;
  std::optional<FrameTally> frames;
  double corner_error_px = 0;  // as in DetectedPicture; 0 if the corners were read
  CommandSeconds seconds;
};

// Reads the input, detects corners if it has no observations, and calibrates. `used`, if not
// null, gets the input with the views that were calibrated. Throws Error for bad input.
CalibrationAnswer run_job(const CalibrationJob& job, Input* used = nullptr);

}  // namespace tagcal::tools
