#pragma once

#include <functional>

#include "tagcal/estimate/types.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// A calibration of a film from a rolling shutter, and its readout: `first` itself if no readout is
// seen in it; else, from that calibration on, the corners are displaced to where the middle row's time would show them and calibrated again,
// until the readout stays. Views without neighbours in time are left out. `calibrate_once` adds
// what is left of the readout.
Calibration calibrate_with_readout(
    const Dataset& dataset, const std::vector<double>& times_s, Calibration first,
    const std::function<Calibration(const Dataset&)>& calibrate_once);

}  // namespace tagcal::internal
