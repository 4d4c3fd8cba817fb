#pragma once

#include <span>

#include "tagcal/estimate/calibration/weak_calibration.hpp"
#include "tagcal/estimate/checks/evidence.hpp"
#include "tagcal/estimate/findings.hpp"

namespace tagcal::internal {

// The input of a check: a solution, the evidence about it, and the answer without findings.
struct Solved {
  Solution solution;
  Evidence evidence;              // of the noise alone for model weak
  const WeakFit* weak = nullptr;  // of model weak
  Calibration answer;
};

// A row of the table of checks: a function that returns a finding, or nothing.
struct Check {
  std::optional<Finding> (*run)(const Solved&);
  bool for_answers_only = false;  // skipped after a refusal
};

// The checks of calibrations with perspective, and of model weak: first the reasons
// not to answer and what explains them, then what limits an answer.
std::span<const Check> checks();
std::span<const Check> weak_checks();

// Runs the checks in their order and appends their findings. The only place that judges a
// calibration.
void run_checks(std::span<const Check> table, const Solved& solved, std::vector<Finding>& findings);

}  // namespace tagcal::internal
