#include "page_data/pages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "job/terminal.hpp"
#include "page_data/page_parts.hpp"
#include "report/fleet.hpp"
#include "tagcal/internal/spread_indices.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kBins = 45;                // of a histogram,
constexpr double kEnd = 4.5;             // up to so many standard deviations to each side
constexpr std::size_t kMostDots = 2000;  // of a control chart, besides the units that fail

bool fails(const JudgedUnit& judged) {
  return judged.verdict != UnitVerdict::ok && judged.verdict != UnitVerdict::not_judged;
}

// (value - centre) over its standard deviation, that of the population and the own one.
double deviation(const Fleet& fleet, const FleetGroup& group, std::size_t i, std::size_t j) {
  const JudgedUnit& judged = fleet.units[i];
  return (judged.unit.row.known.values[j] - group.population.centre[j]) /
         std::hypot(group.population.spread[j], judged.sigma(j));
}

PageJson histogram_json(const Fleet& fleet, const FleetGroup& group, std::size_t j) {
  std::vector<int> counts(kBins, 0);
  int outside = 0;
  for (const std::size_t i : group.units) {
    const double bin = std::floor((deviation(fleet, group, i, j) + kEnd) / (2 * kEnd) * kBins);
    if (bin >= 0 && bin < kBins)
      ++counts[static_cast<std::size_t>(bin)];
    else
      ++outside;
  }
  return {{"end", kEnd}, {"counts", counts}, {"outside", outside}};
}

// The units of a control chart, by date and name: evenly spaced ones, and all that fail.
std::vector<std::size_t> shown_units(const Fleet& fleet, const FleetGroup& group) {
  std::vector<std::size_t> sorted = group.units;
  std::ranges::stable_sort(sorted, {}, [&](std::size_t i) { return fleet.units[i].unit.date; });
  std::vector<bool> is_shown(sorted.size(), false);
  for (const std::size_t k : internal::spread_indices(sorted.size(), kMostDots)) is_shown[k] = true;
  std::vector<std::size_t> shown;
  for (std::size_t k = 0; k < sorted.size(); ++k)
    if (is_shown[k] || fails(fleet.units[sorted[k]])) shown.push_back(sorted[k]);
  return shown;
}

PageJson parameter_json(const Fleet& fleet, const FleetGroup& group,
                        const std::vector<std::size_t>& shown, std::size_t j) {
  const Population& population = group.population;
  const auto at = static_cast<Eigen::Index>(j);
  const Measured centre =
      measured(population.centre[j], std::sqrt(population.centre_covariance(at, at)));
  const Measured spread = measured(population.spread[j], population.sigma_spread[j]);
  PageJson values = PageJson::array();
  for (const std::size_t i : shown)
    values.push_back(significant(fleet.units[i].unit.row.known.values[j], 8));
  return {{"name", group.names[j]},
          {"centre", significant(population.centre[j], 8)},
          {"spread", significant(population.spread[j])},
          {"centre_text", centre.value + " +- " + centre.sigma},
          {"spread_text", spread.value + " +- " + spread.sigma},
          {"own_text", two_digits(usual_own_sigma(fleet, group, j))},
          {"histogram", histogram_json(fleet, group, j)},
          {"values", std::move(values)}};
}

PageJson group_page(const Fleet& fleet, const FleetGroup& group) {
  const std::vector<std::size_t> shown = shown_units(fleet, group);
  PageJson parameters = PageJson::array(), names = PageJson::array(), failing = PageJson::array();
  for (std::size_t j = 0; j < group.names.size(); ++j)
    parameters.push_back(parameter_json(fleet, group, shown, j));
  for (const std::size_t i : shown) {
    names.push_back(fleet.units[i].unit.row.name);
    failing.push_back(fails(fleet.units[i]));
  }
  return {{"title", fmt::format("{} {}, {} x {}", group.lens, group.model, group.image_size.width,
                                group.image_size.height)},
          {"num_units", group.units.size()},
          {"spread_px", group.spread_px ? significant(*group.spread_px, 3) : PageJson()},
          {"units", std::move(names)},
          {"fails", std::move(failing)},
          {"parameters", std::move(parameters)}};
}

std::string link_of(const std::string& name, const fs::path& folder, const fs::path& out) {
  const fs::path beside = fs::absolute(out).parent_path();
  for (const char* ending : {".html", ".yaml"})
    if (const fs::path file = folder / (name + ending); fs::exists(file))
      return fs::absolute(file).lexically_proximate(beside).generic_string();
  return "";
}

PageJson worst_page(const Fleet& fleet, const fs::path& folder, const fs::path& out) {
  PageJson list = PageJson::array();
  for (const std::size_t i : worst_units(fleet, kWorstUnits)) {
    const JudgedUnit& judged = fleet.units[i];
    list.push_back(
        {{"name", judged.unit.row.name},
         {"link", link_of(judged.unit.row.name, folder, out)},
         {"verdict", verdict_name(judged.verdict)},
         {"p_value", significant(judged.distance->p_value, 2)},
         {"most", fleet.groups[judged.group].names[judged.distance->quantity]},
         {"in_sigmas", significant(judged.distance->in_sigmas, 3)},
         {"displacement_px",
          judged.displacement_px ? significant(*judged.displacement_px, 3) : PageJson()}});
  }
  return list;
}

std::string level_of(const Fleet& fleet) {
  const bool is_bad = std::ranges::any_of(fleet.units, [](const JudgedUnit& judged) {
    return fails(judged) && judged.verdict != UnitVerdict::earlier;
  });
  return is_bad ? "warnings" : "ok";
}

}  // namespace

PageJson fleet_page(const Fleet& fleet, const fs::path& folder, const fs::path& out) {
  PageJson groups = PageJson::array(), drifts = PageJson::array();
  std::vector<Finding> findings;
  for (const FleetGroup& group : fleet.groups) {
    for (const Finding& finding : group.population.findings)
      if (!finding.code.empty()) findings.push_back(finding);
    if (!group.population.centre.empty()) groups.push_back(group_page(fleet, group));
  }
  for (const std::string& line : drift_lines(fleet)) drifts.push_back(line);
  return {{"format", 1},
          {"kind", "fleet"},
          {"title", "Fleet " + last_part(folder.string())},
          {"verdict", {{"level", level_of(fleet)}, {"sentence", fleet_verdict(fleet)}}},
          {"made_by", made_by_json()},
          {"notes", fleet.warnings},
          {"findings", page_findings_json(findings)},
          {"fleet",
           {{"groups", std::move(groups)},
            {"worst", worst_page(fleet, folder, out)},
            {"drifts", std::move(drifts)}}}};
}

}  // namespace tagcal::tools
