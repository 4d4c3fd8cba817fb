#pragma once

#include <string>
#include <vector>

#include "page_data/json_values.hpp"
#include "report/handeye_report.hpp"

namespace tagcal::tools {

// An input beside the pictures, by the name of its option: "robot", "poses.csv".
struct InputRow {
  std::string name;
  std::string text;
};

// A hand-eye calibration, with or without an answer. `options`: of that calibration.
PageJson handeye_page(const HandeyeInput& input, const std::vector<InputRow>& inputs,
                      const HandeyeOptions& options, const HandeyeEstimate& answer);

}  // namespace tagcal::tools
