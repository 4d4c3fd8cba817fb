#pragma once

#include <optional>
#include <string>
#include <vector>

#include "job/calibration_job.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal::tools {

// Returns one JSON object (docs/reference/formats.md). Unknown values are null: the camera without
// an estimate, and every free parameter without an answer. A `name` that is not empty is its
// data_set.
std::string calibration_json(const CalibrationAnswer& answer, const std::string& name = "");

// Returns the JSON object of a data set that could not be read.
std::string failure_json(const std::string& name, const std::string& error);

// Sentence about the next view to take.
std::string advice_sentence(const std::optional<AdvisedView>& advice);

// "OK, 1 warning: opencv4 (chosen), 12 pictures, ..", or "NO ANSWER: " and the reason.
std::string verdict_sentence(const Calibration& calibration, bool chosen);

// Whose lenses the cross-check compares.
std::string halves_text(const HalvesCheck& halves);

// "20.0 +- 0.1 ms of the rows, the upper first (from 60 frames)"
std::string readout_text(const Readout& readout);

// Where the noise of the corners comes from, and how large it is.
std::string noise_sentence(const Calibration& calibration);

struct SummaryOptions {
  bool chosen = false;   // the program chose the model
  bool verbose = false;  // with the ladder, the rejected corners and the times
  bool board = false;    // with the terms of the board, even if none is significant
};

// Returns the report for a person: the verdict, what is wrong and what to do, the camera, how good
// it is, the worst pictures.
std::string calibration_summary(const CalibrationAnswer& answer, const SummaryOptions& options);

// Text about the rejected corners: one line per view, with whole views and whole tags summed up and
// single corners with their residuals. The worst views come first; at most twenty lines.
std::string dropped_corners_text(const Calibration& calibration, bool verbose);

}  // namespace tagcal::tools
