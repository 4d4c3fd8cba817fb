#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "tagcal/estimate/advice.hpp"
#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/bundle/projection_effect.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/corner_noise.hpp"
#include "tagcal/estimate/pose/reprojection.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::MatrixXd;
using Points = std::map<CornerId, Eigen::Vector3d>;

// A view that took part in the calibration, with its information for the calibration's noise and
// the inflation of its variances.
struct InformativeView {
  SelectedView view;
  MatrixXd information;
};

// The corners of a view that were not rejected.
ViewProblem problem_of(const View& view, const Points& points, const Calibration& c,
                       const std::set<std::size_t>& rejected) {
  ViewProblem problem;
  for (std::size_t i = 0; i < view.observations.size(); ++i) {
    const Observation& seen = view.observations[i];
    const auto point = points.find(seen.id);
    if (point == points.end() || rejected.contains(i)) continue;
    problem.correspondences.push_back({point->second, seen.pixel});
    if (!c.sigma_of_corners) continue;
    const double error = c.model_error_px * c.model_error_px;
    const Matrix2 covariance = covariance_or_assumed(seen) + error * Matrix2::Identity();
    problem.whitening.push_back(whitening_of(covariance));
  }
  return problem;
}

std::vector<InformativeView> candidates(const Dataset& dataset, const Calibration& c,
                                        const Model& model) {
  const Points points = points_in_world(dataset.boards);
  std::map<std::size_t, std::set<std::size_t>> rejected;
  for (const Outlier& outlier : c.outliers) rejected[outlier.view].insert(outlier.corner);
  const double noise = c.sigma_of_corners ? 1 : c.sigma_px * c.sigma_px;
  const double inflation = std::max(1.0, c.variance_inflation);
  const ViewRowTerms rows{image_centre(c.camera->image_size).y(), c.row_sigma / std::sqrt(noise)};
  std::vector<InformativeView> all;
  for (const CalibratedView& view : c.views) {
    const ViewProblem problem =
        problem_of(dataset.views[view.view], points, c, rejected[view.view]);
    const auto added = information_of(problem, c.camera->lens, model, view.camera_from_world, rows);
    if (!added || !added->schur.allFinite()) continue;
    const int count = static_cast<int>(problem.correspondences.size());
    all.push_back({{view.view, view.image, count, 0}, added->schur / (inflation * noise)});
  }
  return all;
}

double variance_of(const MatrixXd& effect, const MatrixXd& information) {
  const auto covariance = exact_inverse(information);
  return covariance ? (effect * *covariance).trace() : std::numeric_limits<double>::infinity();
}

// The candidate after which the variance is least; the first of equal ones.
std::size_t best_of(const std::vector<InformativeView>& left, const MatrixXd& before,
                    const MatrixXd& effect) {
  std::size_t best = 0;
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < left.size(); ++i) {
    const double variance = variance_of(effect, before + left[i].information);
    if (variance >= lowest) continue;
    lowest = variance;
    best = i;
  }
  return best;
}

// True if a selection ends before a view that changes the standard deviation to `next_px`.
bool ends_before(const ViewSelection& selection, double next_px, const SelectionEnd& end) {
  if (selection.views.empty()) return false;
  const double last_px = selection.views.back().projection_px;
  if (!std::isfinite(last_px)) return false;
  return last_px <= end.goal_px || 1 - std::pow(next_px / last_px, 2) < end.least_gain;
}

}  // namespace

ViewSelection select_views(const Dataset& dataset, const Calibration& calibration, int count,
                           const SelectionEnd& end) {
  assert(count >= 1);
  if (!calibration.camera || calibration.covariance.size() == 0) return {};
  const HeldModels models(calibration.fixed, Model::named(calibration.model).kind());
  const Model& model = models.named(calibration.model);
  const MatrixXd effect = projection_effect(model, *calibration.camera);
  std::vector<InformativeView> left = candidates(dataset, calibration, model);
  MatrixXd all = MatrixXd::Zero(model.num_free(), model.num_free());
  for (const InformativeView& candidate : left) all += candidate.information;
  ViewSelection selection;
  selection.all_px = std::sqrt(variance_of(effect, all));
  // Stands in for what the first views do not determine, and decides nothing once they do.
  constexpr double kLittle = 1e-6;  // numeric: of the information of all views
  MatrixXd sum = MatrixXd::Zero(all.rows(), all.cols());
  while (!left.empty() && selection.views.size() < static_cast<std::size_t>(count)) {
    const std::size_t best = best_of(left, sum + kLittle * all, effect);
    sum += left[best].information;
    left[best].view.projection_px = std::sqrt(variance_of(effect, sum));
    if (ends_before(selection, left[best].view.projection_px, end)) break;
    selection.views.push_back(std::move(left[best].view));
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
  }
  return selection;
}

}  // namespace tagcal
