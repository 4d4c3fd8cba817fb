#pragma once

#include <string>
#include <string_view>

namespace tagcal::internal {

// Returns true for a name that a line of a text file can hold: not empty, and one line.
bool is_image_name(std::string_view image);

// The name of an image as a field of CSV: in double quotes if it has a comma, a double quote or
// outer spaces. Throws Error unless is_image_name.
std::string image_field(const std::string& image);

// The text without blanks at both ends: spaces and tabs, unless others are given.
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t");

}  // namespace tagcal::internal
