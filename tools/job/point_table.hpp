#pragma once

#include <string>
#include <vector>

namespace tagcal::tools {

// A CSV file of points: a line with the names of the columns, then one line a point. Columns are
// found by their names; the others can be repeated in the output.
class PointTable {
 public:
  // Reads a file ("-": stdin). Throws Error, naming file and line: no header, a name given twice,
  // another number of fields, a quote without an end.
  static PointTable read(const std::string& file);

  std::size_t size() const { return rows_.size(); }
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<std::string>& fields(std::size_t row) const { return rows_[row]; }

  // The columns by the first of several sets of names of which all are there; empty if none is.
  // Throws Error if a set is there in part.
  std::vector<std::size_t> find(const std::vector<std::vector<std::string>>& sets) const;
  // The same; throws Error, with the names, if none is there.
  std::vector<std::size_t> need(const std::vector<std::vector<std::string>>& sets) const;

  // The columns of names: point, image and camera, and others unless all their fields are finite
  // numbers, without zeros in front, which a number would lose.
  std::vector<std::string> texts() const;

  // True if a row has nothing in these columns, as those that `valid` = 0 marks.
  bool is_empty(std::size_t row, const std::vector<std::size_t>& columns) const;

  // The finite numbers of a row in these columns. Throws Error, naming file, line and column.
  std::vector<double> numbers(std::size_t row, const std::vector<std::size_t>& columns) const;

  // Throws Error("FILE: line N: COLUMNS: must, got VALUES").
  [[noreturn]] void fail(std::size_t row, const std::vector<std::size_t>& columns,
                         const std::string& must) const;

 private:
  std::string file_;
  std::vector<std::string> names_;
  std::vector<std::vector<std::string>> rows_;
  std::vector<std::size_t> line_numbers_;
};

}  // namespace tagcal::tools
