#pragma once

#include <string>
#include <vector>

#include "tagcal/io/types.hpp"

namespace tagcal::tools {

// The camera of an option, "FILE" or "FILE:NAME" of any format (docs/tasks/convert.md). Prints on
// stderr what reading changed or dropped. Throws Error for a lens that only `tagcal convert` takes.
CalibrationFile read_camera(const std::string& file_and_name);

// The same, which adds the lines to `notes` instead of printing them: for several inputs, all of
// which must be accepted.
CalibrationFile read_camera(const std::string& file_and_name, std::vector<std::string>& notes);

// Prints notes of a conversion of `name` on stderr, one a line.
void print_notes(const std::string& name, const std::vector<std::string>& notes);

}  // namespace tagcal::tools
