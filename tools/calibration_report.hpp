#pragma once

#include <optional>
#include <string>

#include "tagcal/estimate/advice.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal::tools {

// How long the command took, beside what the calibration says of itself.
struct CommandSeconds {
  double read = 0;  // files and detection
  double total = 0;
};

// One JSON object (docs/formats.md). What is not known is null: the camera without an estimate, and
// every free parameter of a status that is no answer.
std::string calibration_json(const Calibration& calibration, const CommandSeconds& seconds,
                             const std::optional<AdvisedView>& advice);

// The next view to take, where it was asked for.
std::string advice_text(const std::optional<AdvisedView>& advice, bool asked);

// The same for people; `chosen` says that the model was not asked for.
std::string calibration_summary(const Calibration& calibration, const CommandSeconds& seconds,
                                bool chosen);

}  // namespace tagcal::tools
