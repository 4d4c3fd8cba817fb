#include "tagcal/io/dataset/csv_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::internal {

CsvRows::CsvRows(const std::filesystem::path& file) : file_(file.string()) {
  const std::string all = read_plain_text(file);
  std::string_view text = all;
  CsvFields csv;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view row = text.substr(0, end);
    if (row.ends_with('\r')) row.remove_suffix(1);
    if (!trimmed(row).empty()) {
      const std::string_view defect = csv.split(row);
      if (!defect.empty()) fail({line, {}}, std::string(defect));
      take({line, {csv.fields().begin(), csv.fields().end()}});
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  if (header_.empty()) throw Error(file_ + ": is empty");
}

void CsvRows::fail(const CsvRow& row, const std::string& message) const {
  throw Error(fmt::format("{}: line {}: {}", file_, row.line, message));
}

void CsvRows::take(CsvRow row) {
  if (header_.empty()) {
    header_ = std::move(row.fields);
    return;
  }
  if (row.fields.size() != header_.size())
    fail(row, fmt::format("must have {} fields, got {}", header_.size(), row.fields.size()));
  rows_.push_back(std::move(row));
}

}  // namespace tagcal::internal
