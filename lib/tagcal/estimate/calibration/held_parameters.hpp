#pragma once

#include <memory>

#include "tagcal/estimate/calibration/calibration_seed.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::internal {

// Parameters that a user fixes, and the start that he gives.

// The model is chosen, not given by its name.
bool is_auto(const CalibrateOptions& options);

// Throw Error for options that no data set can be calibrated with.
void check_start(const CalibrateOptions& options);
void check_fixed(const CalibrateOptions& options);

// All models, with the fixed parameters held. Precondition: check_fixed.
std::shared_ptr<const HeldModels> held_models(const CalibrateOptions& options);

SeedOptions seed_options(const CalibrateOptions& options);

}  // namespace tagcal::internal
