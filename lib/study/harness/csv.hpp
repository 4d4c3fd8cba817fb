#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/io/text_file.hpp"

namespace tagcal::study {

// A line of CSV with its end.
inline std::string csv_line(std::span<const std::string> fields) {
  std::string line;
  for (const std::string& field : fields) line += csv_field(field) + ',';
  line.back() = '\n';
  return line;
}

// The fields of a line; empty if a quote is not closed.
inline std::vector<std::string> csv_cells(std::string_view line) {
  CsvFields cells;
  if (!cells.split(line).empty()) return {};
  return {cells.fields().begin(), cells.fields().end()};
}

}  // namespace tagcal::study
