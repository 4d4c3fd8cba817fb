#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/advice.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::tools {

// What the page of a calibration shows. A calibration that was read from a file has the parts that
// the file and the data set determine; `notes` name the others.
struct PageContent {
  std::string title;
  Calibration calibration;
  std::optional<bool> chosen;  // the program chose the model
  std::optional<AdvisedView> advice;
  std::optional<double> seconds;
  Dataset dataset;  // boards, and views with corners; empty without a data set
  std::map<std::string, std::filesystem::path> pictures;  // files by the names of the views
  std::map<std::string, double> times_s;                  // as Input::times_s
  std::vector<std::string> notes;  // what the page cannot show, a sentence each
  int threads = 1;                 // 0: one per core

  // The estimate of a view of the data set; null if it takes no part.
  const CalibratedView* estimate_of(std::size_t view) const;
};

}  // namespace tagcal::tools
