#pragma once

// Options and answers of calibrations, for tests.

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "tagcal/estimate/calibrate.hpp"

namespace tagcal {

inline CalibrateOptions with_model(std::string model, double sigma_px = 0) {
  CalibrateOptions options;
  options.model = std::move(model);
  options.sigma_px = sigma_px;
  return options;
}

// An answer with a finding of this code.
template <typename Answer>
bool has(const Answer& answer, std::string_view code) {
  return std::ranges::find(answer.findings, code, &Finding::code) != answer.findings.end();
}

}  // namespace tagcal
