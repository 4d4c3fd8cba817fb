// Counts the findings of calibrations of good and of bad data sets (docs/trust/how_sure.md).
// Good sets are calibrated with the model that made them and with `auto`. Bad sets have a board
// that is bent by 0.5 mm, or are calibrated with a model that is one step too small.

#include <algorithm>
#include <array>
#include <string>

#include "random_lens.hpp"
#include "studies/studies.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/findings.hpp"
#include "worlds.hpp"

namespace tagcal {
using namespace study;
namespace {

// The columns of the table.
constexpr std::array<std::pair<const char*, FindingCode>, 9> kKinds = {
    {{"halves", code::halves_disagree},
     {"bent", code::board_bent},
     {"field", code::residuals_biased},
     {"small", code::model_too_small},
     {"target", code::tags_misplaced},
     {"outliers", code::corners_rejected},
     {"weak", code::direction_weak},
     {"trade", code::coefficients_correlated},
     {"gap", code::extrapolated}}};
constexpr std::array<const char*, 4> kOfModel = {"halves", "bent", "field", "small"};

// The column "gap" counts parts of the image without corners, not extrapolation beyond the corners
// alone.
bool is_of_kind(const Finding& finding, const FindingCode& code, const Calibration& c) {
  if (finding.code != code.name) return false;
  return code.name != code::extrapolated.name || c.seen.gaps();
}

// The answer, and whether the findings have each kind.
Values counted(const Dataset& set, const std::string& model, const std::string& name) {
  CalibrateOptions options;
  options.model = model;
  const Calibration c = calibrate(set, options);
  Values values = {name, is_answer(c.status) ? 1. : 0.};
  bool of_model = false;
  for (const auto& [kind, code] : kKinds) {
    const bool found = std::ranges::any_of(
        c.findings, [&](const Finding& finding) { return is_of_kind(finding, code, c); });
    values.emplace_back(found ? 1. : 0.);
    of_model = of_model || (found && std::ranges::count(kOfModel, std::string_view(kind)) > 0);
  }
  values.emplace_back(of_model ? 1. : 0.);
  return values;
}

LensWorld world_of(std::uint64_t seed) {
  LensWorld world(seed);
  world.options.sigma_px = 0.1 + 0.4 * world.random.uniform();
  return world;
}

// The views of make_world() for a board whose middle line is `bend_m` out of its plane.
Dataset bent(const Lens& lens, std::uint64_t seed, const WorldOptions& options, double bend_m) {
  Dataset set = make_world(lens, seed, options);
  std::map<CornerId, Eigen::Vector3d> points;
  for (const TargetPoint& p : target_points(set.boards[0].board)) points[p.id] = p.position;
  double half = 0;
  for (const auto& [id, x] : points) half = std::max(half, 0.5 * x.x());
  Random random(seed, 99);
  for (View& view : set.views) {
    const Pose& pose = set.truth->camera_from_world.at(view.image);
    for (Observation& o : view.observations) {
      Eigen::Vector3d x = points.at(o.id);
      const double across = x.x() / half - 1;
      x.z() += bend_m * (1 - across * across);
      o.pixel = project(lens, pose * x).value_or(o.pixel) +
                options.sigma_px * Eigen::Vector2d(random.normal(), random.normal());
    }
  }
  return set;
}

std::vector<Values> measure(std::uint64_t seed) {
  LensWorld world = world_of(seed);
  const Dataset set = world.make();
  const Dataset curved = bent(world.lens, world.seed, world.options, 5e-4);
  std::vector<Values> rows = {counted(set, world.model, "good, the model by name"),
                              counted(set, "auto", "good, auto"),
                              counted(curved, world.model, "bent by 0.5 mm, by name"),
                              counted(curved, "auto", "bent by 0.5 mm, auto")};
  const std::string below = model_below(world.model);
  if (!below.empty() && world.needs_model(set))
    rows.push_back(counted(set, below, below + " for " + world.model));
  world.options.sigma_px = 0;
  rows.push_back(counted(world.make(), world.model, "exact corners, by name"));
  return rows;
}

}  // namespace

Study warnings_study() {
  Study study = {.name = "warnings",
                 .summary = "findings of calibrations of good and of bad data sets",
                 .columns = {"set", "answer"},
                 .tasks =
                     [](const StudyOptions&) {
                       return std::vector<Task>{{"sets", measure}};
                     },
                 .tables = {{{"set"}, {rows_in("sets"), sum_of("answers", "answer")}}}};
  for (const auto& [kind, code] : kKinds) {
    study.columns.emplace_back(kind);
    study.tables[0].figures.push_back(sum_of(kind, kind));
  }
  study.columns.emplace_back("error");
  study.tables[0].figures.push_back(sum_of("model error", "error"));
  return study;
}

}  // namespace tagcal
