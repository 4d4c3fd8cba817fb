#pragma once

#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "report/fleet_units.hpp"
#include "tagcal/camera/model.hpp"

namespace tagcal::tools {

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

// p below which a unit is outlying, and has drifted.
double outlying_p();

// Compares the units. `history`: also how each serial changed, by dates and temperatures. With
// limits the units are judged by these, and outlying ones are reported only. `threads`: 0, one per
// core.
Fleet judge_fleet(FleetInput input, const std::optional<FleetLimits>& limits, bool history,
                  int threads);

}  // namespace tagcal::tools
