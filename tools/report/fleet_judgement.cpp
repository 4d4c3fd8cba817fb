#include "report/fleet.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>
#include <tuple>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"

namespace tagcal::tools {
namespace {

using internal::YamlValue;

constexpr ImageGrid kGrid{{}, 9, 5};  // over which a projection is compared

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

std::string kind_of_group(const FleetGroup& group) {
  return fmt::format("{} {}x{}", group.model, group.image_size.width, group.image_size.height);
}

// Reasons why a unit is not judged, before any is compared.
void set_aside(JudgedUnit& judged) {
  const FleetRow& row = judged.unit.row;
  if (row.status != "ok" && row.status != "ambiguous") {
    judged.verdict = UnitVerdict::no_answer;
    judged.reason = row.reason.empty() ? row.status : row.reason;
  } else if (!row.reason.empty()) {
    judged.reason = row.reason;
  } else if (const std::string defect = covariance_defect(row.known.covariance); !defect.empty()) {
    judged.reason = "its covariance " + defect;
  }
}

bool can_be_judged(const JudgedUnit& judged) {
  return judged.verdict == UnitVerdict::not_judged && judged.reason.empty();
}

// The calibrations of each serial by date, the latest last. Two of one date are not judged: nothing
// says which of them holds.
std::map<std::string, std::vector<std::size_t>> serials_of(Fleet& fleet) {
  std::map<std::string, std::vector<std::size_t>> serials;
  std::map<std::pair<std::string, double>, std::vector<std::size_t>> dates;
  for (std::size_t i = 0; i < fleet.units.size(); ++i) {
    const FleetUnit& unit = fleet.units[i].unit;
    if (can_be_judged(fleet.units[i])) dates[{unit.serial, unit.days.value_or(-1)}].push_back(i);
  }
  for (const auto& [key, units] : dates) {
    if (units.size() == 1) {
      serials[key.first].push_back(units.front());
      continue;
    }
    const FleetUnit& first = fleet.units[units.front()].unit;
    const std::string text =
        fmt::format("{} calibrations of {} {}", units.size(), key.first,
                    first.date.empty() ? "have no date" : "have the date " + first.date);
    for (const std::size_t i : units) fleet.units[i].reason = text;
    fleet.warnings.push_back(fmt::format("{} ({}, {}{}): not judged; give their dates with --units",
                                         text, first.row.name, fleet.units[units[1]].unit.row.name,
                                         units.size() > 2 ? ", .." : ""));
  }
  return serials;
}

// Every calibration that can be judged gets its group; the latest of each serial is compared.
void form_groups(Fleet& fleet, const std::map<std::string, std::vector<std::size_t>>& serials) {
  std::map<std::tuple<std::string, std::string, std::string, int, int>, std::size_t> places;
  for (const auto& [serial, units] : serials) {
    for (const std::size_t i : units) {
      const FleetRow& row = fleet.units[i].unit.row;
      const auto [place, is_new] = places.emplace(
          std::tuple(row.lens, row.model, row.names, row.image_size.width, row.image_size.height),
          fleet.groups.size());
      if (is_new)
        fleet.groups.push_back({row.lens, row.model, row.image_size, words_of(row.names)});
      fleet.units[i].group = place->second;
      if (i == units.back())
        fleet.groups[place->second].units.push_back(i);
      else
        fleet.units[i].verdict = UnitVerdict::earlier;
    }
  }
  for (FleetGroup& group : fleet.groups) std::ranges::sort(group.units);
}

void warn_of_mixtures(Fleet& fleet) {
  if (fleet.groups.size() > 1) {
    std::string kinds;
    for (const FleetGroup& group : fleet.groups)
      kinds += fmt::format("{}{} ({})", kinds.empty() ? "" : ", ", kind_of_group(group),
                           group.units.size());
    fleet.warnings.push_back("units of different models or image sizes are compared apart: " +
                             kinds + "; calibrate --model gives all the same");
  }
  std::map<std::string, int> made_by;
  for (const JudgedUnit& judged : fleet.units)
    if (!judged.unit.row.made_by.empty()) ++made_by[judged.unit.row.made_by];
  if (made_by.size() < 2) return;
  const auto most = std::ranges::max_element(made_by, {}, [](const auto& m) { return m.second; });
  fleet.warnings.push_back(fmt::format(
      "the calibrations were made with {} different options or versions, {} of {} by \"{}\"; "
      "calibrate all alike",
      made_by.size(), most->second, fleet.units.size(), most->first));
}

// Rays of the centre's camera over the image.
std::vector<Eigen::Vector3d> rays_of(const Camera& centre) {
  ImageGrid grid = kGrid;
  grid.size = centre.image_size;
  std::vector<Eigen::Vector3d> rays;
  for (const Eigen::Vector2d& pixel : grid.pixels())
    if (const auto ray = ray_in_camera(centre.lens, pixel)) rays.push_back(ray->direction);
  return rays;
}

double rms(const std::vector<double>& squares) {
  double sum = 0;
  for (const double square : squares) sum += square;
  return std::sqrt(sum / static_cast<double>(squares.size()));
}

std::optional<double> displacement_of(const Lens& lens, const Lens& centre,
                                      const std::vector<Eigen::Vector3d>& rays) {
  std::vector<double> squares;
  for (const Eigen::Vector3d& ray : rays) {
    const auto a = project(lens, ray), b = project(centre, ray);
    if (a && b) squares.push_back((*a - *b).squaredNorm());
  }
  return squares.empty() ? std::nullopt : std::optional(rms(squares));
}

// The camera of the centre, and the spread of the projection.
void set_centre(FleetGroup& group, const Model& model, const std::vector<Eigen::Vector3d>& rays) {
  const UncertainCamera spread{&model, *group.centre, group.population.scatter};
  std::vector<double> variances;
  for (const Eigen::Vector3d& ray : rays)
    if (const auto pixel = project(spread, {ray, Eigen::Matrix3d::Zero()}))
      variances.push_back(pixel->covariance_px2.trace() / 2);
  if (!variances.empty()) group.spread_px = rms(variances);
}

void compare_projections(Fleet& fleet, FleetGroup& group, int threads) {
  const Model* const model = model_of(fleet.units[group.units.front()].unit.row);
  const auto lens = model ? model->lens(group.population.centre, group.image_size) : std::nullopt;
  if (!lens) return;
  group.centre = Camera{*lens, group.image_size};
  const std::vector<Eigen::Vector3d> rays = rays_of(*group.centre);
  set_centre(group, *model, rays);
  internal::parallel_for(group.units.size(), threads, [&](std::size_t k) {
    JudgedUnit& judged = fleet.units[group.units[k]];
    if (const auto own = model->lens(judged.unit.row.known.values, group.image_size))
      judged.displacement_px = displacement_of(*own, *lens, rays);
  });
}

void compare_group(Fleet& fleet, FleetGroup& group, int threads) {
  std::vector<UnitValues> known;
  for (const std::size_t i : group.units) known.push_back(fleet.units[i].unit.row.known);
  try {
    group.population = estimate_population(known, group.names);
  } catch (const Error& error) {
    group.population = {};
    group.population.findings = {{"", Severity::refusal, error.what()}};
  }
  for (const Finding& finding : group.population.findings)
    if (finding.severity != Severity::note)
      fleet.warnings.push_back(kind_of_group(group) + ": " + finding.sentence);
  if (!is_answer(group.population.status)) return;
  internal::parallel_for(known.size(), threads, [&](std::size_t k) {
    fleet.units[group.units[k]].distance = unit_distance(group.population, known[k]);
  });
  compare_projections(fleet, group, threads);
}

std::string excess_of(const std::string& name, double value, double low, double high) {
  if (value >= low && value <= high) return "";
  return fmt::format("{} {:.6g} is {} {:.6g}", name, value, value < low ? "below" : "above",
                     value < low ? low : high);
}

// What is beyond the limits, the first of them.
std::string beyond_limits(const JudgedUnit& judged, const FleetGroup& group,
                          const FleetLimits& limits) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  std::string text;
  for (std::size_t j = 0; j < group.names.size() && text.empty(); ++j)
    if (const auto limit = limits.parameters.find(group.names[j]); limit != limits.parameters.end())
      text = excess_of(group.names[j], judged.unit.row.known.values[j], limit->second.first,
                       limit->second.second);
  if (text.empty() && limits.rms_px)
    text = excess_of("rms_px", judged.unit.row.rms_px, kNone, *limits.rms_px);
  if (text.empty() && limits.displacement_px && judged.displacement_px)
    text = excess_of("displacement_px", *judged.displacement_px, kNone, *limits.displacement_px);
  return text;
}

// Throws Error for a parameter that no unit has.
void check_limits(const Fleet& fleet, const FleetLimits& limits) {
  for (const auto& [name, range] : limits.parameters) {
    const bool is_known = std::ranges::any_of(fleet.groups, [&](const FleetGroup& group) {
      return std::ranges::find(group.names, name) != group.names.end();
    });
    if (!is_known && !fleet.groups.empty())
      throw Error(fmt::format("--limits: {} is no parameter of these units ({})", name,
                              fmt::join(fleet.groups.front().names, ", ")));
  }
}

void judge_unit(JudgedUnit& judged, const FleetGroup& group,
                const std::optional<FleetLimits>& limits) {
  if (limits) {
    judged.reason = beyond_limits(judged, group, *limits);
    judged.verdict = judged.reason.empty() ? UnitVerdict::ok : UnitVerdict::out_of_limits;
    return;
  }
  if (!judged.distance) {
    judged.reason = group.population.findings.front().sentence;
    return;
  }
  judged.verdict =
      judged.distance->p_value < outlying_p() ? UnitVerdict::outlying : UnitVerdict::ok;
  if (judged.verdict == UnitVerdict::outlying)
    judged.reason = fmt::format("{} {:+.1f} sd", group.names[judged.distance->quantity],
                                judged.distance->in_sigmas);
}

}  // namespace

const char* verdict_name(UnitVerdict verdict) {
  constexpr const char* kNames[] = {"ok",        "outlying", "out_of_limits", "drifted",
                                    "no_answer", "earlier",  "not_judged"};
  return kNames[static_cast<std::size_t>(verdict)];
}

double JudgedUnit::sigma(std::size_t parameter) const {
  const auto at = static_cast<Eigen::Index>(parameter);
  return std::sqrt(unit.row.known.covariance(at, at));
}

std::size_t Fleet::count(UnitVerdict verdict) const {
  return static_cast<std::size_t>(std::ranges::count(units, verdict, &JudgedUnit::verdict));
}

FleetLimits read_fleet_limits(const std::filesystem::path& file) {
  const YamlValue top = YamlValue::read(file);
  top.allow_only({"parameters", "rms_px", "displacement_px"});
  FleetLimits limits;
  if (const auto parameters = top.find("parameters"))
    for (const auto& [name, value] : parameters->members()) {
      const std::vector<double> range = value.numbers(2);
      if (range[0] > range[1]) value.fail_plainly("the first number must not be above the second");
      limits.parameters[name] = {range[0], range[1]};
    }
  if (const auto rms_px = top.find("rms_px")) limits.rms_px = rms_px->positive();
  if (const auto displacement = top.find("displacement_px"))
    limits.displacement_px = displacement->positive();
  return limits;
}

Fleet judge_fleet(FleetInput input, const std::optional<FleetLimits>& limits, bool history,
                  int threads) {
  Fleet fleet;
  fleet.warnings = std::move(input.warnings);
  fleet.has_limits = limits.has_value();
  for (FleetUnit& unit : input.units) fleet.units.push_back({std::move(unit)});
  for (JudgedUnit& judged : fleet.units) set_aside(judged);
  const auto serials = serials_of(fleet);
  form_groups(fleet, serials);
  warn_of_mixtures(fleet);
  if (limits) check_limits(fleet, *limits);
  for (FleetGroup& group : fleet.groups) {
    if (group.units.empty()) continue;
    compare_group(fleet, group, threads);
    for (const std::size_t i : group.units) judge_unit(fleet.units[i], group, limits);
  }
  if (history) judge_drifts(fleet, serials, threads);
  return fleet;
}

}  // namespace tagcal::tools
