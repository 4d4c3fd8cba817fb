#pragma once

#include <string>

#include "job/input.hpp"
#include "page_data/page_content.hpp"
#include "tagcal/io/types.hpp"

namespace tagcal::tools {

// What a file says of a camera, as a calibration without views.
Calibration calibration_of(const CalibrationFile& file);

// The content of the page of a calibration file ("FILE" or "FILE:NAME", of any program). With
// `input` (not null) its views get poses and residuals under that camera; their corners are found
// in the pictures if the data set has none.
PageContent content_from_file(const std::string& file_and_name, Input* input, int threads);

}  // namespace tagcal::tools
