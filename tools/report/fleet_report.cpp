#include "report/fleet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "job/terminal.hpp"

namespace tagcal::tools {
namespace {

constexpr std::size_t kNamed = 3;  // units of the verdict

// "12 not_observable, 9 degenerate, 8 error"
std::string statuses_text(const Fleet& fleet) {
  std::map<std::string, std::size_t> counts;
  for (const JudgedUnit& judged : fleet.units) ++counts[judged.unit.row.status];
  std::string text = fmt::format("{} ok", counts["ok"]);
  counts.erase("ok");
  for (const auto& [status, count] : counts) text += fmt::format(", {} {}", count, status);
  return text;
}

// "; 6 outlying (..): cam0412 fx +5.1 sd", with the worst first.
std::string failures_text(const Fleet& fleet, UnitVerdict verdict, const std::string& note) {
  std::vector<const JudgedUnit*> failures;
  for (const JudgedUnit& judged : fleet.units)
    if (judged.verdict == verdict) failures.push_back(&judged);
  std::ranges::stable_sort(failures, std::greater(), [](const JudgedUnit* judged) {
    return judged->distance ? judged->distance->squared : 0;
  });
  if (failures.empty() && verdict != UnitVerdict::outlying) return "";
  std::string text = fmt::format("; {} {}{}", failures.size(), verdict_name(verdict), note);
  for (std::size_t i = 0; i < std::min(failures.size(), kNamed); ++i)
    text += fmt::format("{} {} {}", i == 0 ? ":" : ",", failures[i]->unit.row.name,
                        failures[i]->reason);
  return text + (failures.size() > kNamed ? ", .." : "");
}

std::size_t num_compared(const Fleet& fleet) {
  return static_cast<std::size_t>(std::ranges::count_if(
      fleet.units, [](const JudgedUnit& judged) { return judged.distance.has_value(); }));
}

// A parameter of the population: its centre, the spread between units, and the usual own standard
// deviation.
std::string population_line(const Fleet& fleet, const FleetGroup& group, std::size_t j) {
  const Population& population = group.population;
  const auto at = static_cast<Eigen::Index>(j);
  const Measured centre =
      measured(population.centre[j], std::sqrt(population.centre_covariance(at, at)));
  const Measured spread = measured(population.spread[j], population.sigma_spread[j]);
  return fmt::format("  {:<5} {:>11} +- {:<9} {:>10} +- {:<9} {:>10.2g}\n", group.names[j],
                     centre.value, centre.sigma, spread.value, spread.sigma,
                     usual_own_sigma(fleet, group, j));
}

std::string group_text(const Fleet& fleet, const FleetGroup& group) {
  std::string text =
      fmt::format("{} {} {}x{}: {}\n", group.lens, group.model, group.image_size.width,
                  group.image_size.height, counted(group.units.size(), "unit"));
  if (group.population.centre.empty()) return text;
  text += fmt::format("  {:<5} {:>11}    {:<9} {:>10}    {:<9} {:>10}\n", "", "centre", "sd",
                      "spread", "sd", "own sd");
  for (std::size_t j = 0; j < group.names.size(); ++j) text += population_line(fleet, group, j);
  if (group.spread_px)
    text += fmt::format(
        "  projection: units differ by {} px per coordinate (spread, RMS over the "
        "image)\n",
        two_digits(*group.spread_px));
  for (const Finding& finding : group.population.findings)
    if (finding.severity == Severity::note) text += "  note: " + finding.sentence + "\n";
  return text;
}

std::string worst_text(const Fleet& fleet) {
  const std::vector<std::size_t> worst = worst_units(fleet, kWorstUnits);
  if (worst.empty()) return "";
  std::size_t width = 4;
  for (const std::size_t i : worst) width = std::max(width, fleet.units[i].unit.row.name.size());
  std::string text = fmt::format("{:<{}}  {:<13}  {:>8}  {:<5}  {:>7}  {:>8}\n", "unit", width,
                                 "verdict", "p", "most", "sd", "px");
  for (const std::size_t i : worst) {
    const JudgedUnit& judged = fleet.units[i];
    const FleetGroup& group = fleet.groups[judged.group];
    text += fmt::format("{:<{}}  {:<13}  {:>8.2g}  {:<5}  {:>+7.1f}  {:>8}\n", judged.unit.row.name,
                        width, verdict_name(judged.verdict), judged.distance->p_value,
                        group.names[judged.distance->quantity], judged.distance->in_sigmas,
                        judged.displacement_px ? two_digits(*judged.displacement_px) : "-");
  }
  return text;
}

std::string drift_text(const Fleet& fleet) {
  if (fleet.drifts.empty()) return "";
  std::string text = fmt::format("drift of {} over their calibrations (own variances x {:.2f})\n",
                                 counted(fleet.drifts.size(), "serial"), fleet.inflation);
  for (const std::string& line : drift_lines(fleet)) text += "  " + line + "\n";
  return text;
}

}  // namespace

std::vector<std::size_t> worst_units(const Fleet& fleet, std::size_t most) {
  std::vector<std::size_t> units;
  for (std::size_t i = 0; i < fleet.units.size(); ++i)
    if (fleet.units[i].distance) units.push_back(i);
  const auto unlike = [&](std::size_t i) {
    const UnitDistance& distance = *fleet.units[i].distance;
    return std::pair(distance.p_value, -distance.squared);
  };
  const auto end = units.begin() + static_cast<std::ptrdiff_t>(std::min(most, units.size()));
  std::ranges::partial_sort(units, end, {}, unlike);
  units.erase(end, units.end());
  return units;
}

std::vector<std::string> drift_lines(const Fleet& fleet) {
  std::vector<const FleetDrift*> drifts;
  for (const FleetDrift& drift : fleet.drifts) drifts.push_back(&drift);
  std::ranges::stable_sort(drifts, {}, &FleetDrift::p_days);
  std::vector<std::string> lines;
  for (std::size_t k = 0; k < std::min(drifts.size(), kWorstUnits); ++k) {
    const FleetDrift& drift = *drifts[k];
    const auto at = static_cast<Eigen::Index>(drift.parameter);
    const Measured slope =
        measured(kYearDays * drift.trend.slopes(at, 0),
                 kYearDays * std::sqrt(fleet.inflation) * drift.trend.sigmas(at, 0));
    lines.push_back(fmt::format(
        "{}: {} {} +- {} a year, p {:.2g} ({} calibrations){}", drift.serial,
        fleet.groups[drift.group].names[drift.parameter], slope.value, slope.sigma, drift.p_days,
        drift.units.size(),
        drift.p_temperature ? fmt::format("; temperature p {:.2g}", *drift.p_temperature) : ""));
  }
  return lines;
}

double usual_own_sigma(const Fleet& fleet, const FleetGroup& group, std::size_t parameter) {
  std::vector<double> own;
  for (const std::size_t i : group.units) own.push_back(fleet.units[i].sigma(parameter));
  const auto middle = own.begin() + std::ssize(own) / 2;
  std::ranges::nth_element(own, middle);
  return *middle;
}

std::string fleet_verdict(const Fleet& fleet) {
  std::string text = fmt::format("{} sets: {}", fleet.units.size(), statuses_text(fleet));
  const double by_chance = outlying_p() * static_cast<double>(num_compared(fleet));
  if (fleet.has_limits)
    text += failures_text(fleet, UnitVerdict::out_of_limits, "");
  else
    text += failures_text(fleet, UnitVerdict::outlying,
                          fmt::format(" (p < {:.0e}, {:.1f} by chance)", outlying_p(), by_chance));
  text += failures_text(fleet, UnitVerdict::drifted, "");
  if (const std::size_t count = fleet.count(UnitVerdict::not_judged); count > 0)
    text += fmt::format("; {} not judged", count);
  return text;
}

std::string fleet_text(const Fleet& fleet) {
  std::string text = fleet_verdict(fleet) + "\n";
  for (const FleetGroup& group : fleet.groups)
    if (!group.units.empty()) text += group_text(fleet, group);
  text += worst_text(fleet) + drift_text(fleet);
  std::size_t said = 0;
  for (const JudgedUnit& judged : fleet.units)
    if (judged.verdict == UnitVerdict::not_judged && ++said <= kWorstUnits)
      text += fmt::format("not judged: {}: {}\n", judged.unit.row.name, judged.reason);
  return text + (said > kWorstUnits ? fmt::format("and {} more\n", said - kWorstUnits) : "");
}

}  // namespace tagcal::tools
