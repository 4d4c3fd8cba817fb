#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tagcal::study {

// A field of a CSV file, in quotes if it needs them.
std::string csv_field(const std::string& text);

// A line with its end.
std::string csv_line(std::span<const std::string> fields);

std::vector<std::string> csv_cells(std::string_view line);

}  // namespace tagcal::study
