#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "report/fleet_judgement.hpp"

namespace tagcal::tools {

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
