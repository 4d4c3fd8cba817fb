#pragma once

#include "tagcal/io/formats/lens_numbers.hpp"

// mrcal's .cameramodel: a dictionary of Python.

namespace tagcal::internal {

// Returns true if the text begins, after comments, with a dictionary that has a lens.
bool is_mrcal_model(std::string_view text);

CameraFile read_mrcal(const std::string& text, const std::string& file);
FormatOutput write_mrcal(const CameraFile& file);

}  // namespace tagcal::internal
