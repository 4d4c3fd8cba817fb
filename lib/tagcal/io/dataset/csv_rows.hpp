#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

// Private to io: a small table of CSV, read whole.

namespace tagcal::internal {

struct CsvRow {
  std::size_t line = 0;             // in the file, from 1
  std::vector<std::string> fields;  // as many as the header has
};

// The header and rows of a file; empty lines are left out. Throws Error, naming file and line, for
// a file without a header and for a row with another number of fields.
class CsvRows {
 public:
  explicit CsvRows(const std::filesystem::path& file);

  const std::vector<std::string>& header() const { return header_; }
  const std::vector<CsvRow>& rows() const { return rows_; }

  // Throws Error("FILE: line N: message").
  [[noreturn]] void fail(const CsvRow& row, const std::string& message) const;

 private:
  void take(CsvRow row);

  std::string file_;
  std::vector<std::string> header_;
  std::vector<CsvRow> rows_;
};

}  // namespace tagcal::internal
