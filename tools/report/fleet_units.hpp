#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "report/fleet_row.hpp"

namespace tagcal::tools {

// A calibration of a unit of a fleet.
struct FleetUnit {
  FleetRow row;
  std::string serial;          // the unit that was calibrated
  std::string date;            // as in 2026-03-01; "": not known
  std::optional<double> days;  // the same since 1970
  std::optional<double> temperature_c;
};

// The unit of a name: SERIAL_2026-03-01 has its date at the end.
FleetUnit named_unit(std::string name);

struct FleetInput {
  std::vector<FleetUnit> units;       // by name
  std::vector<std::string> warnings;  // files that are no calibrations, a sentence each
};

// Reads what `calibrate --out FOLDER` wrote: the summaries of FOLDER/summary, and files of cameras
// without one. A name SERIAL_2026-03-01 has its date at the end; `table` (a CSV file with the
// columns name, serial, date, temperature_c, of which name alone must be there; "": none) says
// otherwise. Throws Error if the folder has no calibration, and for mistakes of the table.
FleetInput read_fleet(const std::filesystem::path& folder, const std::filesystem::path& table,
                      int threads);

}  // namespace tagcal::tools
