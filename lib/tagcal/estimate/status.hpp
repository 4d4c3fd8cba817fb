#pragma once

#include <string_view>

namespace tagcal {

// What an estimate says of itself. Only `ok` and `ambiguous` are answers.
enum class Status {
  ok,
  ambiguous,             // a single view fits two poses; both are given, with odds
  focal_not_observable,  // sd(f) / f above 10 %
  not_observable,        // other parameters, named in the warnings
  degenerate,            // points on a line, duplicates, too few
  no_consensus,          // outliers win
  not_converged,
};

std::string_view status_name(Status status);  // as in the enum
inline bool is_answer(Status status) { return status == Status::ok || status == Status::ambiguous; }

}  // namespace tagcal
