#include "report/fleet.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal::tools {
namespace {

// The calibrations of a serial that have a date and the kind of the latest.
std::vector<std::size_t> dated_units(const Fleet& fleet, const std::vector<std::size_t>& units) {
  std::vector<std::size_t> dated;
  for (const std::size_t i : units)
    if (fleet.units[i].unit.days && fleet.units[i].group == fleet.units[units.back()].group)
      dated.push_back(i);
  return dated;
}

// By days and, if all have one, temperature.
MatrixX covariates_of(const Fleet& fleet, const std::vector<std::size_t>& units) {
  const bool has_temperatures = std::ranges::all_of(
      units, [&](std::size_t i) { return fleet.units[i].unit.temperature_c.has_value(); });
  MatrixX covariates(static_cast<Eigen::Index>(units.size()), has_temperatures ? 2 : 1);
  for (Eigen::Index k = 0; k < covariates.rows(); ++k) {
    const FleetUnit& unit = fleet.units[units[static_cast<std::size_t>(k)]].unit;
    covariates(k, 0) = *unit.days;
    if (has_temperatures) covariates(k, 1) = *unit.temperature_c;
  }
  return covariates;
}

std::optional<FleetDrift> drift_of(const Fleet& fleet, const std::vector<std::size_t>& all) {
  FleetDrift drift;
  drift.units = dated_units(fleet, all);
  if (drift.units.size() < 2) return std::nullopt;
  drift.group = fleet.units[all.back()].group;
  drift.serial = fleet.units[all.back()].unit.serial;
  std::vector<UnitValues> known;
  for (const std::size_t i : drift.units) known.push_back(fleet.units[i].unit.row.known);
  const MatrixX covariates = covariates_of(fleet, drift.units);
  std::optional<Trend> trend;
  try {
    trend = estimate_trend(known, covariates);
    drift.by_temperature = trend && covariates.cols() == 2;
    if (!trend) trend = estimate_trend(known, covariates.leftCols(1));
  } catch (const Error&) {
    return std::nullopt;  // a covariance is singular
  }
  if (!trend) return std::nullopt;
  drift.trend = std::move(*trend);
  return drift;
}

void judge_drift(Fleet& fleet, FleetDrift& drift) {
  drift.p_days = *trend_p_value(drift.trend, 0, fleet.inflation);
  if (drift.by_temperature) drift.p_temperature = trend_p_value(drift.trend, 1, fleet.inflation);
  drift.p_scatter = trend_p_value(drift.trend, std::nullopt, fleet.inflation);
  Eigen::Index most = 0;
  (drift.trend.slopes.col(0).array() / drift.trend.sigmas.col(0).array()).abs().maxCoeff(&most);
  drift.parameter = static_cast<std::size_t>(most);
  JudgedUnit& latest = fleet.units[drift.units.back()];
  const bool is_trend = drift.p_days < outlying_p();
  const bool is_change = drift.p_scatter.value_or(1) < outlying_p();
  if (latest.verdict != UnitVerdict::ok || !(is_trend || is_change)) return;
  latest.verdict = UnitVerdict::drifted;
  latest.reason =
      is_trend ? fmt::format("{} {:+.3g} +- {:.2g} a year",
                             fleet.groups[drift.group].names[drift.parameter],
                             kYearDays * drift.trend.slopes(most, 0),
                             kYearDays * std::sqrt(fleet.inflation) * drift.trend.sigmas(most, 0))
               : "it changed between its calibrations by more than their uncertainty";
}

}  // namespace

void judge_drifts(Fleet& fleet, const std::map<std::string, std::vector<std::size_t>>& serials,
                  int threads) {
  std::vector<const std::vector<std::size_t>*> lists;
  for (const auto& [serial, units] : serials) lists.push_back(&units);
  std::vector<std::optional<FleetDrift>> drifts(lists.size());
  internal::parallel_for(lists.size(), threads,
                         [&](std::size_t i) { drifts[i] = drift_of(fleet, *lists[i]); });
  std::vector<Trend> trends;
  for (std::optional<FleetDrift>& drift : drifts) {
    if (!drift) continue;
    trends.push_back(drift->trend);
    fleet.drifts.push_back(std::move(*drift));
  }
  fleet.inflation = repeat_inflation(trends);
  for (FleetDrift& drift : fleet.drifts) judge_drift(fleet, drift);
}

}  // namespace tagcal::tools
