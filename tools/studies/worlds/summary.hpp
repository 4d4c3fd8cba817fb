#pragma once

#include <string>
#include <vector>

#include "record.hpp"

namespace tagcal {

// Markdown tables for each mode: of all records, by defect, and by what corners or pictures are.
std::string summary(const std::vector<Record>& records);

// One line that describes a world and its result.
std::string one_line(const Record& record);

}  // namespace tagcal
