#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "record.hpp"

namespace tagcal {

// The kinds in which a world may be wrong, and by which the worst are found.
enum class Wrong { beyond, focal, region, image, corners, refused, diagnosis };
Wrong wrong_named(std::string_view name);  // throws Error for an unknown one

// By how much a record is wrong in this way; right ones have 0. Ratios are divided by the five
// standard deviations that are allowed, so that wrong ones are above 1.
double wrongness(const Record& record, Wrong kind);

// The classes of diagnoses that are false in this record, each once.
std::vector<std::string_view> false_diagnoses(const Record& record);

// What all records say, as a Markdown table; then one by model. `before`, which may be empty: the
// same worlds by another version, whose tags count as those that can be read.
std::string summary(const std::vector<Record>& records, const std::vector<Record>& before);

// One line that says what a world was and what became of it.
std::string one_line(const Record& record);

}  // namespace tagcal
