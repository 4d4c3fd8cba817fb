#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tagcal/camera/camera.hpp"
#include "tagcal/estimate/fleet.hpp"
#include "tagcal/io/types.hpp"

namespace tagcal::tools {

// The folder in that of `calibrate --out` with a summary NAME.json of each data set.
inline constexpr const char* kSummaryFolder = "summary";

// What a fleet needs of the calibration of one data set, the part of its summary
// (many_outcomes.hpp) that `tagcal fleet` reads: a hundred thousand of these are in memory at once.
struct FleetRow {
  std::string name;
  std::string status;   // as status_name, or "error"
  std::string reason;   // of no answer, of an error, or why the unit cannot be judged
  std::string made_by;  // version and options; "": not known
  std::string lens;     // its kind
  std::string model;    // of the claim; "": no covariance
  std::string names;    // of its free parameters, with blanks between them
  ImageSize image_size;
  UnitValues known;   // these parameters
  double rms_px = 0;  // 0: not known
};

// The row of an answer, or of a calibration without one.
FleetRow fleet_row(const std::string& name, const Calibration& calibration);
// That of a camera's file.
FleetRow fleet_row(const std::string& name, const CalibrationFile& file);

// The model of a row; null if --fix held some of its parameters.
const Model* model_of(const FleetRow& row);

// All but name and made_by, the key `unit` of a summary.
nlohmann::json fleet_row_json(const FleetRow& row);

// The row of a summary; its status is "error" if the file is damaged.
FleetRow read_summary(const std::filesystem::path& file);

}  // namespace tagcal::tools
