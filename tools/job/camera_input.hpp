#pragma once

#include <string>
#include <vector>

#include "tagcal/io/types.hpp"

namespace tagcal::tools {

// The camera of an option, "FILE" or "FILE:NAME" of any format (docs/tasks/convert.md). What
// reading changed or dropped is a note (hold_note). Throws Error for a lens that only `tagcal
// convert` takes.
CalibrationFile read_camera(const std::string& file_and_name);

// Holds the notes of a conversion of `name`.
void hold_notes(const std::string& name, const std::vector<std::string>& notes);

}  // namespace tagcal::tools
