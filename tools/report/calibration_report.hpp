#pragma once

#include <optional>
#include <string>

#include "commands/calibration_job.hpp"

namespace tagcal::tools {

// One JSON object (docs/formats.md). What is not known is null: the camera without an estimate, and
// every free parameter of a status that is no answer. Of several data sets each says its name.
std::string calibration_json(const CalibrationAnswer& answer, const std::string& name = "");

// A data set that could not be read, in the place of such an object.
std::string failure_json(const std::string& name, const std::string& error);

// The next view to take, where it was asked for.
std::string advice_sentence(const std::optional<AdvisedView>& advice);

// The same for people; `chosen` says that the model was not asked for.
std::string calibration_summary(const CalibrationAnswer& answer, bool chosen);

}  // namespace tagcal::tools
