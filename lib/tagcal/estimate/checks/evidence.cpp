#include "tagcal/estimate/checks/evidence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "tagcal/estimate/calibration/kinds.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/stopwatch.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

// No value for a model that is not smaller.
std::optional<LargerLens> larger_lens(const Bundle& solved, double sigma) {
  const Model& usual = solved.model->sibling(kind_of<Perspective>(), ModelRole::usual);
  if (solved.model->kind().reaches_behind || solved.model->num_free() >= usual.num_free())
    return std::nullopt;
  const auto information = bundle_information(with_model(solved, usual));
  const auto inverse = information ? exact_inverse(information->total(sigma)) : std::nullopt;
  if (!inverse) return std::nullopt;
  const Eigen::VectorXd gradient = information->gradient(sigma);
  const double chi_square = gradient.dot(*inverse * gradient);
  // numeric: no division by zero for exact corners
  const double cost = std::max(cost_of(solved), 1e-300);
  constexpr double kMost = 0.99;  // numeric: to first order the gain can exceed the whole
  return LargerLens{chi_square, std::min(kMost, chi_square * sigma * sigma / cost)};
}

// The linear standard deviation of the focal length of model f+c over that of a solved model f.
double open_centre(const Bundle& solved, double sigma) {
  if (solved.model->name() != "f" || !solved.model->held().empty()) return 1;
  const auto own = bundle_information(solved);
  const auto open = bundle_information(with_model(solved, Model::named("f+c")));
  const auto a = own ? exact_inverse(own->total(sigma)) : std::nullopt;
  const auto b = open ? exact_inverse(open->total(sigma)) : std::nullopt;
  return a && b ? std::sqrt((*b)(0, 0) / (*a)(0, 0)) : 1;
}

// The views that belong, or do not belong, to a source.
CalibrationInput views_of_source(const Solution& solution, const std::string& source,
                                 bool belongs) {
  CalibrationInput part = without_views(*solution.input);
  for (const CalibrationView& view : solution.input->views)
    if ((solution.options->sources[view.index] == source) == belongs) part.views.push_back(view);
  return part;
}

// The sources to compare with all others: those with enough views whose others have enough. Of two
// sources one is, which is compared with the other.
std::set<std::string> compared_sources(const Solution& solution) {
  std::map<std::string, std::ptrdiff_t> num_views;
  for (const CalibrationView& view : solution.input->views)
    ++num_views[solution.options->sources[view.index]];
  std::set<std::string> compared;
  for (const auto& [source, n] : num_views)
    if (n >= policy::kFewestComparedViews &&
        std::ssize(solution.input->views) - n >= policy::kFewestComparedViews)
      compared.insert(source);
  if (num_views.size() == 2 && compared.size() == 2) compared.erase(std::prev(compared.end()));
  return compared;
}

// The views of one source and all others, for each source that can be compared, or else the views
// in turn; the comparison that differs most. Sources are fitted each by themselves: the common fit
// explains much of two lenses by row terms, which then hide the difference.
std::optional<HalvesCheck> compare_halves(const Solution& solution, const Evidence& evidence) {
  const Posterior& posterior = solution.choice->posterior;
  const std::vector<Eigen::Vector2d> samples = evidence.seen.samples();
  const Eigen::Index k = posterior.model().num_free();
  std::set<std::string> sources;
  if (!solution.options->sources.empty() && k > 0) sources = compared_sources(solution);
  if (sources.empty())
    return split_half_check(posterior.fit.bundle, posterior.information, evidence.floored_sigma,
                            samples, evidence.distance_m);
  std::optional<HalvesCheck> worst;
  for (const std::string& source : sources) {
    std::array<std::optional<Posterior>, 2> parts;
    for (const bool belongs : {false, true})
      parts[belongs] = fit_posterior(posterior.model(), views_of_source(solution, source, belongs),
                                     *solution.options);
    if (!parts[0] || !parts[1]) continue;
    auto check =
        compare_lenses(posterior.fit.bundle, (parts[1]->values() - parts[0]->values()).head(k),
                       parts[0]->covariance.parameters + parts[1]->covariance.parameters, samples,
                       evidence.distance_m);
    if (!check || (worst && worst->ratio >= check->ratio)) continue;
    check->source = source;
    worst = std::move(check);
  }
  return worst;
}

// Tests for a target that is not as its file says: a corner's residuals then have the same
// direction on the board in all views. No test if a larger lens explains more of the residuals, or
// if the fit is no minimum. A refused focal length may be the consequence of a wrong target.
std::optional<TargetError> find_target_error(const Evidence& evidence, const Solution& solution) {
  const Status seen = evidence.observability.status;
  if (!(seen == Status::ok && evidence.at_minimum) && seen != Status::focal_not_observable)
    return std::nullopt;
  auto error = target_error(*solution.input, *solution.fit);
  if (error && evidence.larger &&
      evidence.larger->share > std::max(error->share, policy::kLargerLensShare))
    return std::nullopt;
  return error;
}

}  // namespace

bool Evidence::is_model_small() const {
  // opencv5 has at most eight parameters more.
  return larger && larger->chi_square >= chi_square_quantile(8, policy::kOutlierSigmas);
}

Evidence evidence_of_noise(const CalibrationFit& fit, const CalibrateOptions& options) {
  Evidence evidence;
  evidence.noise = noise_of(fit, options);
  evidence.floored_sigma = std::max(evidence.noise.sigma, least_sigma(fit.whitened, options));
  evidence.seen = seen_region(fit.bundle);
  return evidence;
}

Evidence gather_evidence(const Solution& solution) {
  const Stopwatch stopwatch;
  const CalibrationFit& fit = *solution.fit;
  const Posterior& posterior = solution.choice->posterior;
  const BundleCovariance& claim = solution.choice->claim;
  Evidence evidence = evidence_of_noise(fit, *solution.options);
  evidence.distance_m = median_distance_m(fit.bundle);
  evidence.observability = observability(fit.bundle, posterior.model(), claim.parameters);
  const double share = evidence.noise.sigma / evidence.floored_sigma;
  evidence.at_minimum =
      fit.summary.converged && share * share * claim.decrement <= policy::kExcludedCost;
  evidence.bias = residual_bias(fit.bundle, least_sigma(fit.whitened, *solution.options));
  evidence.halves = compare_halves(solution, evidence);
  if (!is_auto(*solution.options)) {
    evidence.larger = larger_lens(fit.bundle, evidence.floored_sigma);
    evidence.open_centre = open_centre(fit.bundle, evidence.noise.sigma);
  }
  if (fit.bundle.board) evidence.board = board_warp(fit.bundle, claim);
  evidence.target = find_target_error(evidence, solution);
  evidence.seconds = stopwatch.seconds();
  return evidence;
}

bool is_impossible(const BoardWarp& board, const FlatBoard& flat) {
  const double largest_mm = policy::kLargestBoardBend * 2e3 * flat.half_size.norm();
  return std::max(board.bend_mm.cwiseAbs().maxCoeff(), std::abs(board.twist_mm)) > largest_mm;
}

}  // namespace tagcal::internal
