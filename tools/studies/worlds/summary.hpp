#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "record.hpp"

namespace tagcal {

// The ways in which the answer of a world can be wrong; `worst` sorts by one of them.
enum class Wrong { beyond, focal, region, image, corners, refused, diagnosis };
Wrong wrong_named(std::string_view name);  // throws Error for an unknown one

// How wrong a record is in this way: ratios divided by the five standard deviations that are
// allowed, so that wrong ones are above 1.
double wrongness(const Record& record, Wrong kind);

// The kinds of false diagnoses in this record, each once.
std::vector<std::string_view> false_diagnoses(const Record& record);

// Markdown tables of all records, and of the records by model. `before` (may be empty) has the same
// worlds by another version, whose tags are those that can be read.
std::string summary(const std::vector<Record>& records, const std::vector<Record>& before);

// One line that describes a world and its result.
std::string one_line(const Record& record);

}  // namespace tagcal
