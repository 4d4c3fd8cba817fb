#include "tagcal/estimate/calibration/calibration_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>

#include "tagcal/error.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/corner_noise.hpp"
#include "tagcal/estimate/pose/pose_problem.hpp"
#include "tagcal/estimate/pose/view_checks.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/solvers/numeric/point_spread.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Position of a corner in the world, and the index of its board.
struct WorldPoint {
  Vector3d position;
  std::size_t board;
};

std::map<CornerId, WorldPoint> world_points(const std::vector<PlacedBoard>& boards) {
  std::map<CornerId, WorldPoint> points;
  for (std::size_t b = 0; b < boards.size(); ++b)
    for (const TargetPoint& p : target_points(boards[b].board))
      points[p.id] = {boards[b].world_from_board * p.position, b};
  return points;
}

CalibrationView calibration_view(const View& view, std::size_t index,
                                 const std::map<CornerId, WorldPoint>& points, bool whitened) {
  CalibrationView result;
  result.image = view.image;
  result.index = index;
  std::map<std::size_t, std::vector<std::uint32_t>> by_board;
  result.corners.reserve(view.observations.size());
  result.ids.reserve(view.observations.size());
  result.problem.correspondences.reserve(view.observations.size());
  if (whitened) result.problem.whitening.reserve(view.observations.size());
  auto point = points.begin();
  for (std::size_t i = 0; i < view.observations.size(); ++i) {
    const Observation& o = view.observations[i];
    // Corners mostly have the order of the board, so the next point is tried before the search.
    if (point != points.end()) ++point;
    if (point == points.end() || point->first != o.id) point = points.find(o.id);
    if (point == points.end()) continue;
    by_board[point->second.board].push_back(static_cast<std::uint32_t>(result.ids.size()));
    result.ids.push_back(o.id);
    result.corners.push_back(static_cast<std::uint32_t>(i));
    result.problem.correspondences.push_back({point->second.position, o.pixel});
    if (whitened) result.problem.whitening.push_back(whitening_of(covariance_or_assumed(o)));
  }
  for (const auto& [board, indices] : by_board)
    if (indices.size() > result.seed.size()) result.seed = indices;
  return result;
}

bool determines_pose(const CalibrationView& view) {
  if (view.seed.size() < policy::kLeastViewCorners) return false;
  std::vector<Vector3d> points;
  for (const std::size_t i : view.seed) points.push_back(view.problem.correspondences[i].point);
  const PointShape shape = spread_of(points).shape;
  return shape == PointShape::plane || shape == PointShape::space;
}

bool same_corners(const CalibrationView& a, const CalibrationView& b) {
  return a.ids == b.ids &&
         std::equal(
             a.problem.correspondences.begin(), a.problem.correspondences.end(),
             b.problem.correspondences.begin(),
             [](const Correspondence& x, const Correspondence& y) { return x.pixel == y.pixel; });
}

// Indices of views by the sum of their pixel coordinates: repeated views have equal sums.
using ViewsBySum = std::unordered_multimap<double, std::size_t>;

double sum_of_pixels(const CalibrationView& view) {
  double sum = 0;
  for (const Correspondence& c : view.problem.correspondences) sum += c.pixel.x() + c.pixel.y();
  return sum;
}

// Lists the corners of a mirrored view in input.rejected; false for any other view.
bool reject_mirrored(const CalibrationView& view, CalibrationInput& input) {
  if (!is_mirrored(view.ids, view.problem.correspondences)) return false;
  add(input.findings, code::view_mirrored, view.name() + ": rejected, its tags are mirrored");
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < view.ids.size(); ++i)
    input.rejected.push_back({view.image, view.ids[i], unknown, view.index, view.corners[i]});
  return true;
}

// True for a view with the corners of an earlier one, and adds a finding.
bool is_repeated(const CalibrationView& view, const ViewsBySum& earlier, CalibrationInput& input) {
  const auto [first, last] = earlier.equal_range(sum_of_pixels(view));
  const auto same = std::find_if(first, last, [&](const auto& other) {
    return same_corners(input.views[other.second], view);
  });
  if (same == last) return false;
  add(input.findings, code::view_repeated,
      view.name() + ": not used, it repeats " + input.views[same->second].name());
  return true;
}

// Without a model: the kind that most lenses have.
const LensKind& lens_kind(const CalibrateOptions& options) {
  return is_auto(options) ? kind_of<Perspective>() : Model::named(options.model).kind();
}

void check_start(const CalibrateOptions& options) {
  if (!std::isfinite(options.start_focal_px) || options.start_focal_px < 0)
    throw Error("start_focal_px: must be > 0, got " + short_number(options.start_focal_px));
  if (!options.start) return;
  if (options.start_focal_px > 0) throw Error("start: give a camera or a focal length, not both");
  const LensKind& kind = kind_of(options.start->lens);
  if (!kind.is_central || (!is_auto(options) && &kind != &lens_kind(options)))
    throw Error("start: is a " + std::string(kind.name) + " lens, model " +
                (is_auto(options) ? "auto" : options.model) + " needs another kind of lens");
}

void check_fixed(const CalibrateOptions& options) {
  if (options.fixed.empty()) return;
  const LensKind& kind = lens_kind(options);
  if (!kind.is_central) throw Error("fixed: model weak has no parameter that can be fixed");
  const HeldModels models(options.fixed, kind);
  for (const auto& [name, value] : options.fixed) {
    const auto parameter = std::ranges::find(kind.parameters, name, &LensParameter::name);
    if (name == "f" || parameter->role == ParameterRole::focal_length ||
        parameter->role == ParameterRole::principal_point)
      continue;
    if (is_auto(options))
      throw Error("fixed: " + name + " needs a model by its name: auto tries several lenses");
    const Model& full = Model::named(options.model).sibling(kind, ModelRole::largest);
    if (parameter->power < 0 && options.model != full.name())
      throw Error("fixed: " + name + " is a parameter of model " + std::string(full.name()) +
                  ", got " + options.model);
  }
  if (is_auto(options)) return;
  const Model& model = models.named(options.model);  // a larger one if all parameters are fixed
  if (model.num_free() == 0 || model.name() != options.model)
    throw Error("fixed: no parameter of model " + options.model + " is left to estimate");
}

}  // namespace

bool is_auto(const CalibrateOptions& options) {
  return options.model.empty() || options.model == "auto";
}

std::shared_ptr<const HeldModels> models_of(const CalibrateOptions& options) {
  return std::make_shared<const HeldModels>(options.fixed, lens_kind(options));
}

SeedOptions seed_options(const CalibrateOptions& options) {
  return {options.start ? &options.start->lens : nullptr, options.start_focal_px,
          !options.reject_outliers, options.num_threads};
}

void check_lens_options(const CalibrateOptions& options) {
  check_start(options);
  check_fixed(options);
}

CalibrationInput calibration_input(const Dataset& dataset, const CalibrateOptions& options) {
  CalibrationInput input;
  input.models = models_of(options);
  input.image_size = dataset.image_size;
  const auto points = world_points(dataset.boards);
  CornerNoise noise;
  for (const View& view : dataset.views) noise.add(view);
  input.whitened = options.sigma_px == 0 && noise.counts();
  if (input.whitened && noise.num_assumed() > 0)
    add(input.findings, code::covariance_missing,
        fmt::format(
            "{} of {} corners have no covariance of their own: {} px of noise is assumed for them",
            noise.num_assumed(), noise.num_corners, policy::kAssumedSigmaPx));
  std::size_t outside = 0, num_corners = 0;
  ViewsBySum earlier;
  for (std::size_t v = 0; v < dataset.views.size(); ++v) {
    CalibrationView prepared = calibration_view(dataset.views[v], v, points, input.whitened);
    outside += num_outside(prepared.problem.correspondences, dataset.image_size);
    num_corners += prepared.ids.size();
    if (dataset.views[v].observations.empty()) continue;  // the search for corners says why
    if (!determines_pose(prepared)) {
      add(input.findings, code::view_unusable,
          prepared.name() +
              ": not used, it has no four corners of one board that determine a pose");
      continue;
    }
    if (is_repeated(prepared, earlier, input)) continue;
    if (options.reject_outliers && reject_mirrored(prepared, input)) continue;
    earlier.emplace(sum_of_pixels(prepared), input.views.size());
    input.views.push_back(std::move(prepared));
  }
  if (auto warning = corners_outside(outside, num_corners, dataset.image_size))
    input.findings.push_back(*std::move(warning));
  return input;
}

}  // namespace tagcal::internal
