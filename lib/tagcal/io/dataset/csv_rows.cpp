#include "tagcal/io/dataset/csv_rows.hpp"

#include <fmt/format.h>

#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::internal {

CsvRows::CsvRows(const std::filesystem::path& file) : file_(file.string()) {
  CsvFields csv;
  for_each_line(read_plain_text(file), [&](std::string_view line, std::size_t number) {
    if (trimmed(line).empty()) return;
    const std::string_view defect = csv.split(line);
    if (!defect.empty()) fail({number, {}}, std::string(defect));
    take({number, {csv.fields().begin(), csv.fields().end()}});
  });
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
