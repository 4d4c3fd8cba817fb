#pragma once

#include <string_view>

namespace tagcal {

// The result of an estimate. Only `ok` and `ambiguous` are answers.
enum class Status {
  ok,
  ambiguous,             // a single view fits two poses; both are given, with probabilities
  focal_not_observable,  // the data do not determine the focal length: sd(f) / f above 10 %
  not_observable,        // the data do not determine other parameters; a finding names them
  degenerate,            // points on a line, repeated points, or too few
  no_consensus,          // too many outliers for one common answer
  not_converged,         // the solver stopped at no minimum
};

std::string_view status_name(Status status);  // as in the enum
inline bool is_answer(Status status) { return status == Status::ok || status == Status::ambiguous; }

}  // namespace tagcal
