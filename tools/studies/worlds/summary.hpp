#pragma once

#include <string>
#include <vector>

#include "record.hpp"

namespace tagcal {

// Markdown tables for each mode: of all records, by defect, by number of views and by model.
// `before` (may be empty) has the same worlds by another version, whose tags are those that can be
// read.
std::string summary(const std::vector<Record>& records, const std::vector<Record>& before);

// One line that describes a world and its result.
std::string one_line(const Record& record);

}  // namespace tagcal
