#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "job/plain_text.hpp"
#include "report/findings.hpp"
#include "report/fleet.hpp"
#include "report/json_parts.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::ordered_json;

Json unit_json(const Fleet& fleet, const JudgedUnit& judged) {
  const FleetRow& row = judged.unit.row;
  Json json = {{"name", row.name},
               {"serial", judged.unit.serial},
               {"date", judged.unit.date.empty() ? Json() : Json(judged.unit.date)},
               {"temperature_c", optional_json(judged.unit.temperature_c)},
               {"status", row.status},
               {"verdict", verdict_name(judged.verdict)},
               {"reason", judged.reason}};
  if (row.known.values.empty()) return json;
  std::vector<double> sigmas;
  for (std::size_t j = 0; j < row.known.values.size(); ++j) sigmas.push_back(judged.sigma(j));
  json["values"] = row.known.values;
  json["sigmas"] = sigmas;
  json["rms_px"] = row.rms_px;
  if (!judged.distance) return json;
  json["group"] = judged.group;
  json["squared_distance"] = judged.distance->squared;
  json["p_value"] = judged.distance->p_value;
  json["most"] = fleet.groups[judged.group].names[judged.distance->quantity];
  json["in_sigmas"] = judged.distance->in_sigmas;
  json["displacement_px"] = optional_json(judged.displacement_px);
  return json;
}

Json group_json(const FleetGroup& group) {
  const Population& population = group.population;
  Json json = {{"lens", group.lens},
               {"model", group.model},
               {"image_size", {group.image_size.width, group.image_size.height}},
               {"parameters", group.names},
               {"num_units", group.units.size()},
               {"status", status_name(population.status)},
               {"findings", findings_json(population.findings)}};
  if (population.centre.empty()) return json;
  json["num_used"] = population.num_used;
  json["centre"] = population.centre;
  json["centre_covariance"] = matrix_json(population.centre_covariance);
  json["spread"] = population.spread;
  json["sigma_spread"] = population.sigma_spread;
  json["scatter"] = matrix_json(population.scatter);
  json["spread_px"] = optional_json(group.spread_px);
  return json;
}

Json drift_json(const Fleet& fleet, const FleetDrift& drift) {
  Json units = Json::array();
  for (const std::size_t i : drift.units) units.push_back(fleet.units[i].unit.row.name);
  return {{"serial", drift.serial},
          {"units", std::move(units)},
          {"parameters", fleet.groups[drift.group].names},
          {"covariates",
           drift.by_temperature ? Json::array({"days", "temperature_c"}) : Json::array({"days"})},
          {"slopes", matrix_json(drift.trend.slopes)},
          {"sigmas", matrix_json(std::sqrt(fleet.inflation) * drift.trend.sigmas)},
          {"p_days", drift.p_days},
          {"p_temperature", optional_json(drift.p_temperature)},
          {"p_scatter", optional_json(drift.p_scatter)}};
}

// The parameters of all groups, in the order of the first that has them.
std::vector<std::string> all_parameters(const Fleet& fleet) {
  std::vector<std::string> names;
  for (const FleetGroup& group : fleet.groups)
    for (const std::string& name : group.names)
      if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  return names;
}

std::string csv_line(const Fleet& fleet, const JudgedUnit& judged,
                     const std::vector<std::string>& names) {
  const FleetUnit& unit = judged.unit;
  std::string line = fmt::format(
      "{},{},{},{},{},{},{}", csv_field(unit.row.name), csv_field(unit.serial), unit.date,
      unit.temperature_c ? fmt::format("{}", *unit.temperature_c) : "", unit.row.status,
      verdict_name(judged.verdict), csv_field(one_line_text(judged.reason)));
  line += judged.distance
              ? fmt::format(",{},{}", judged.distance->squared, judged.distance->p_value)
              : ",,";
  line += judged.displacement_px ? fmt::format(",{}", *judged.displacement_px) : ",";
  const bool is_known = !unit.row.known.values.empty();
  const FleetGroup* const group =
      is_known && judged.group < fleet.groups.size() ? &fleet.groups[judged.group] : nullptr;
  for (const std::string& name : names) {
    const auto at = group ? std::ranges::find(group->names, name) - group->names.begin() : 0;
    const auto j = static_cast<std::size_t>(at);
    line += group && j < group->names.size()
                ? fmt::format(",{},{}", unit.row.known.values[j], judged.sigma(j))
                : ",,";
  }
  return line + "\n";
}

}  // namespace

std::string fleet_csv(const Fleet& fleet) {
  const std::vector<std::string> names = all_parameters(fleet);
  std::string text =
      "name,serial,date,temperature_c,status,verdict,reason,squared_distance,p_value,"
      "displacement_px";
  for (const std::string& name : names) text += fmt::format(",{},sd_{}", name, name);
  text += "\n";
  for (const JudgedUnit& judged : fleet.units) text += csv_line(fleet, judged, names);
  return text;
}

Json fleet_json(const Fleet& fleet) {
  Json units = Json::array(), groups = Json::array(), drifts = Json::array(), worst = Json::array();
  for (const JudgedUnit& judged : fleet.units) units.push_back(unit_json(fleet, judged));
  for (const FleetGroup& group : fleet.groups) groups.push_back(group_json(group));
  for (const FleetDrift& drift : fleet.drifts) drifts.push_back(drift_json(fleet, drift));
  for (const std::size_t i : worst_units(fleet, kWorstUnits))
    worst.push_back(fleet.units[i].unit.row.name);
  return {{"format", 1},
          {"verdict", fleet_verdict(fleet)},
          {"outlying_p", outlying_p()},
          {"warnings", fleet.warnings},
          {"groups", std::move(groups)},
          {"worst", std::move(worst)},
          {"inflation", fleet.inflation},
          {"drifts", std::move(drifts)},
          {"units", std::move(units)}};
}

}  // namespace tagcal::tools
