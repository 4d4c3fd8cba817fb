#pragma once

#include <string>
#include <vector>

#include "record.hpp"

// Tables of records by one of their properties, in Markdown.

namespace tagcal {

std::string by_defect(const std::vector<Record>& records);   // a world of two or more is "several"
std::string by_corners(const std::vector<Record>& records);  // what is given: covariances, outliers
std::string by_light(const std::vector<Record>& records);    // of pixel mode
std::string by_pictures(const std::vector<Record>& records);  // of pixel mode, corners and f

}  // namespace tagcal
