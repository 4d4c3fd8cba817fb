#pragma once

#include <string>
#include <vector>

#include "corner_methods.hpp"
#include "study/harness/study.hpp"

// What studies of corners share: exact corners; and the rows of `checkers`, and its pictures in
// files.

namespace tagcal {

ExactCorners corners_of(const std::vector<Observation>& observations);

// The corners of one board in each view by a calibration of all views (fisheye4), or as they were
// found in fewer than three views.
std::vector<ExactCorners> exact_by_calibration(const Dataset& set);

// The columns of a row, and what a line of a table says of its rows: `boards`, the heading of their
// number; and, `with_bound`, the errors beside the bound.
std::vector<std::string> checker_columns();
std::vector<study::Figure> checker_figures(const std::string& boards, bool with_bound);

// A row of the study. A corner is wrong if it is off by more than `wrong_px`; the squares are of
// errors.
study::Values checker_row(const std::string& method, const ExactCorners& exact,
                          const FoundCorners& found, double bound_square, double wrong_px = 0.5);

// For each set of pictures a task of one trial: data sets that `tagcal render` made, folders of
// pictures with a target.yaml, and the files among the inputs, which are one set. `target`: of all
// that have none. Without a truth the exact corners are those of a calibration of all pictures by
// the corners of whichever method has most, and the squares are of held-out residuals: of every
// other corner under a calibration by the others. Throws Error.
std::vector<study::Task> picture_tasks(const std::vector<std::string>& inputs,
                                       const std::string& target);

}  // namespace tagcal
