#include "job/point_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <iterator>
#include <set>
#include <string_view>

#include "job/plain_text.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

std::string joined(const std::vector<std::string>& names) { return internal::joined(names, ","); }

std::string text_of(const std::string& file) {
  if (file != "-") return read_plain_text(file);
  std::string text{std::istreambuf_iterator<char>(std::cin), {}};
  remove_byte_order_mark(text);
  check_plain_text(text, "stdin");
  return text;
}

bool is_text(const std::string& field) {
  if (field.empty()) return false;
  const auto number = number_of<double>(field);
  if (!number || !std::isfinite(*number)) return true;
  const std::string_view digits = std::string_view(field).substr(field[0] == '-' ? 1 : 0);
  return digits.size() > 1 && digits[0] == '0' && digits[1] >= '0' && digits[1] <= '9';
}

}  // namespace

PointTable PointTable::read(const std::string& file) {
  PointTable table;
  table.file_ = file == "-" ? "stdin" : file;
  CsvFields csv;
  for_each_line(text_of(file), [&](std::string_view line, std::size_t number) {
    line = trimmed(line, " \t\r");
    if (line.empty() || line.starts_with('#')) return;
    const std::string_view defect = csv.split(line);
    if (!defect.empty()) throw Error(fmt::format("{}: line {}: {}", table.file_, number, defect));
    std::vector<std::string> fields(csv.fields().begin(), csv.fields().end());
    if (table.names_.empty()) {
      table.names_ = std::move(fields);
      std::set<std::string> names;
      for (const std::string& name : table.names_)
        if (!names.insert(name).second)
          throw Error(fmt::format("{}: the column \"{}\" is there twice", table.file_, name));
      return;
    }
    if (fields.size() != table.names_.size())
      throw Error(fmt::format("{}: line {}: must have {} fields as the header, got {}", table.file_,
                              number, table.names_.size(), fields.size()));
    table.rows_.push_back(std::move(fields));
    table.line_numbers_.push_back(number);
  });
  if (table.names_.empty())
    throw Error(fmt::format("{}: must begin with a line of column names", table.file_));
  return table;
}

std::vector<std::string> PointTable::texts() const {
  const std::set<std::string> of_names = {"point", "image", "camera"};
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < names_.size(); ++i)
    if (of_names.contains(names_[i]) ||
        std::ranges::any_of(rows_, [i](const auto& fields) { return is_text(fields[i]); }))
      texts.push_back(names_[i]);
  return texts;
}

bool PointTable::is_empty(std::size_t row, const std::vector<std::size_t>& columns) const {
  return std::ranges::all_of(columns,
                             [&](std::size_t column) { return rows_[row][column].empty(); });
}

std::vector<std::size_t> PointTable::find(const std::vector<std::vector<std::string>>& sets) const {
  for (const std::vector<std::string>& set : sets) {
    std::vector<std::size_t> columns;
    std::string missing;
    for (const std::string& name : set) {
      const auto place = std::ranges::find(names_, name);
      if (place == names_.end())
        missing = name;
      else
        columns.push_back(static_cast<std::size_t>(place - names_.begin()));
    }
    if (missing.empty()) return columns;
    if (!columns.empty())
      throw Error(fmt::format("{}: has the column \"{}\" but not \"{}\"", file_,
                              names_[columns.front()], missing));
  }
  return {};
}

std::vector<std::size_t> PointTable::need(const std::vector<std::vector<std::string>>& sets) const {
  std::vector<std::size_t> columns = find(sets);
  if (!columns.empty()) return columns;
  throw Error(fmt::format("{}: must have the columns {}, has {}", file_,
                          internal::joined(sets, " or ", joined), joined(names_)));
}

std::vector<double> PointTable::numbers(std::size_t row,
                                        const std::vector<std::size_t>& columns) const {
  const std::vector<std::string>& fields = rows_[row];
  std::vector<double> numbers;
  for (const std::size_t column : columns) {
    const auto number = number_of<double>(fields[column]);
    if (!number || !std::isfinite(*number)) fail(row, {column}, "must be a finite number");
    numbers.push_back(*number);
  }
  return numbers;
}

void PointTable::fail(std::size_t row, const std::vector<std::size_t>& columns,
                      const std::string& must) const {
  std::vector<std::string> names, values;
  for (const std::size_t column : columns) {
    names.push_back(names_[column]);
    values.push_back(rows_[row][column]);
  }
  throw Error(fmt::format("{}: line {}: {}: {}, got \"{}\"", file_, line_numbers_[row],
                          joined(names), must, joined(values)));
}

}  // namespace tagcal::tools
