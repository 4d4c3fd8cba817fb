#pragma once

#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/camera/model.hpp"
#include "tagcal/estimate/fleet.hpp"
#include "tagcal/io/types.hpp"

namespace tagcal::tools {

// The folder in that of `calibrate --out` with a summary NAME.json of each data set.
inline constexpr const char* kSummaryFolder = "summary";

inline constexpr double kYearDays = 365.25;

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

// What is judged of a unit. `outlying`, `out_of_limits`, `drifted` and `no_answer` are failures.
// `earlier`: a later calibration of its serial is judged.
enum class UnitVerdict { ok, outlying, out_of_limits, drifted, no_answer, earlier, not_judged };
const char* verdict_name(UnitVerdict verdict);

// Limits of a file: of parameters by name, and the largest values of the others.
struct FleetLimits {
  std::map<std::string, std::pair<double, double>> parameters;
  std::optional<double> rms_px;
  std::optional<double> displacement_px;
};

// `parameters: {fx: [900, 950]}`, `rms_px: 0.5`, `displacement_px: 3`. Throws Error.
FleetLimits read_fleet_limits(const std::filesystem::path& file);

struct JudgedUnit {
  FleetUnit unit;
  UnitVerdict verdict = UnitVerdict::not_judged;
  std::string reason;                    // of the verdict; "" if ok
  std::size_t group = kNoGroup;          // of its kind
  std::optional<UnitDistance> distance;  // no value: it was not compared
  // How far the projection is from the population's centre: RMS over the image, length of (du, dv).
  std::optional<double> displacement_px;

  static constexpr std::size_t kNoGroup = std::numeric_limits<std::size_t>::max();
  // The own standard deviation of a parameter.
  double sigma(std::size_t parameter) const;
};

// Calibrations of one kind of lens, model and image size, which can be compared.
struct FleetGroup {
  std::string lens, model;
  ImageSize image_size;
  std::vector<std::string> names;  // of the parameters
  std::vector<std::size_t> units;  // that are compared: the latest of each serial
  Population population;
  std::optional<Camera> centre;     // no value without a population
  std::optional<double> spread_px;  // of the projection per coordinate, RMS over the image
};

// How one serial changes over its calibrations.
struct FleetDrift {
  std::string serial;
  std::size_t group = 0;
  std::vector<std::size_t> units;  // by date
  bool by_temperature = false;     // the second covariate; the first is the time in days
  Trend trend;
  double p_days = 1;
  std::optional<double> p_temperature;
  std::optional<double> p_scatter;  // of changes that are no trend
  std::size_t parameter = 0;        // that drifts most, in standard deviations
};

struct Fleet {
  std::vector<JudgedUnit> units;  // by name
  std::vector<FleetGroup> groups;
  std::vector<FleetDrift> drifts;     // by serial
  double inflation = 1;               // of the variances, by repeated calibrations
  std::vector<std::string> warnings;  // a sentence each
  bool has_limits = false;

  std::size_t count(UnitVerdict verdict) const;
};

// Compares the units. `history`: also how each serial changed, by dates and temperatures. With
// limits the units are judged by these, and outlying ones are reported only. `threads`: 0, one per
// core.
Fleet judge_fleet(FleetInput input, const std::optional<FleetLimits>& limits, bool history,
                  int threads);

// Adds how each serial with two dates or more changed, and judges its latest calibration, if that
// is ok until then, by it. `serials`: their calibrations by date.
void judge_drifts(Fleet& fleet, const std::map<std::string, std::vector<std::size_t>>& serials,
                  int threads);

// "10000 sets: 9971 ok, .. 6 outlying (p < 1e-4, 1.0 by chance): cam0412 fx +5.1 sd", without a
// line end. At most three units are named.
std::string fleet_verdict(const Fleet& fleet);

// For a person: the verdict, the population, the ten worst units, and what drifts.
std::string fleet_text(const Fleet& fleet);

// A row for each unit: name, serial, date, temperature, verdict, distance, p, and its parameters
// with their standard deviations.
std::string fleet_csv(const Fleet& fleet);

nlohmann::ordered_json fleet_json(const Fleet& fleet);

inline constexpr std::size_t kWorstUnits = 10;  // that are named

// The units with a distance, the most unlike first, at most `most` of them (indices).
std::vector<std::size_t> worst_units(const Fleet& fleet, std::size_t most);

// The serials that drift most, a sentence each, at most kWorstUnits.
std::vector<std::string> drift_lines(const Fleet& fleet);

// The median of the own standard deviations of a parameter.
double usual_own_sigma(const Fleet& fleet, const FleetGroup& group, std::size_t parameter);

}  // namespace tagcal::tools
