#pragma once

#include <vector>

#include "tagcal/estimate/checks/evidence.hpp"
#include "tagcal/estimate/findings.hpp"

namespace tagcal::internal {

// The input of a check: a solution, the evidence about it, and the answer without findings.
struct Solved {
  Solution solution;
  Evidence evidence;  // of the noise alone for model weak
  Calibration answer;
};

// Runs the checks in their order and appends their findings: first the reasons not to answer and
// what explains them, then what limits an answer. The only place that judges a calibration.
void run_checks(const Solved& solved, std::vector<Finding>& findings);

}  // namespace tagcal::internal
