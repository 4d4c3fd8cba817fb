#pragma once

#include <memory>

#include "tagcal/estimate/calibration/calibration_seed.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::internal {

// What a user states before a calibration: where it starts and what it holds.

// Throws Error for what no data set could be calibrated with.
void check_start(const CalibrateOptions& options);
void check_fixed(const CalibrateOptions& options);

// The ladder with what is held. Precondition: check_fixed.
std::shared_ptr<const HeldModels> held_models(const CalibrateOptions& options);

StartOptions start_options(const CalibrateOptions& options);

}  // namespace tagcal::internal
