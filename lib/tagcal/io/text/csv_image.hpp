#pragma once

#include <deque>
#include <string>
#include <string_view>
#include <vector>

namespace tagcal::internal {

// Returns true for a name that a line of a text file can hold: not empty, and one line.
bool is_image_name(std::string_view image);

// The name of an image as a field of CSV: in double quotes if it has a comma, a double quote or
// outer spaces, or begins as a comment (#). Throws Error unless is_image_name.
std::string image_field(const std::string& image);

// Any text of one line as a field of CSV, in the same way.
std::string csv_field(std::string_view text);

// The fields of lines of CSV, without the blanks around them. A field may be in double quotes, with
// "" for a double quote.
class CsvFields {
 public:
  // Replaces the fields by those of a line, and returns what is wrong with it; "" if nothing is.
  std::string_view split(std::string_view line);

  // Valid as long as the line, and until the next call of split.
  const std::vector<std::string_view>& fields() const { return fields_; }

 private:
  std::vector<std::string_view> fields_;
  std::deque<std::string> unquoted_;
};

// The text without blanks at both ends: spaces and tabs, unless others are given.
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t");

}  // namespace tagcal::internal
