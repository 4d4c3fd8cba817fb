#include "tagcal/estimate/pose/robust_pose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/pose_ransac.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"
#include "tagcal/estimate/pose/shifted_tag_test.hpp"

namespace tagcal::internal {
namespace {

constexpr const char* kNoCommonPose =
    "the points do not agree on one pose: check the lens and the target";

template <int N>
RobustPose<N> no_fit(const FindingCode& code, const std::string& reason) {
  RobustPose<N> result;
  add(result.findings, code, reason);
  return result;
}

template <int N>
ResidualTest residual_test_of(const PoseProblem& problem, const Lens& lens,
                              const PoseMinima<N>& fit) {
  // If the sum of the squares is below the limit of one, none exceeds it. The limit of the sum is
  // the smaller one for few points.
  const double freedom = 2 * static_cast<double>(problem.size()) - N;
  const double limit = std::min(policy::kOutlierSigmas * policy::kOutlierSigmas,
                                chi_square_quantile(freedom, policy::kSignificant));
  const double variance = fit.noise.sigma_px * fit.noise.sigma_px;
  if (fit.best().cost <= limit * variance) return ResidualTest::consistent;
  ViewResiduals residuals(lens, problem.view());
  return residual_test(problem, fit.noise, residuals.at(fit.best().state), N);
}

// The noise is in units of the corners' covariances if the problem is whitened.
std::string understated_sentence(const PoseProblem& problem, const NoiseLevel& stated,
                                 double sigma_px) {
  if (problem.whitened())
    return fmt::format(
        "the residuals are {:.1f} times as large as the corners' covariances say: pose and "
        "standard deviations are for covariances scaled to that; check them, the lens and the "
        "target",
        sigma_px / stated.sigma_px);
  return fmt::format(
      "the residuals are {:.1f} times as large as the {} noise: pose and standard deviations are "
      "for {:.2g} px; check the noise, the lens and the target",
      sigma_px / stated.sigma_px, stated.assumed ? "assumed" : "stated", sigma_px);
}

// Tests the residuals of the inliers' fit. If they are even, but too large for the stated or
// assumed noise, raises it and searches for the minima again: the smaller noise may have excluded a
// pose that fits under the larger one.
template <int N>
void test_and_raise_noise(const Lens& lens, const PoseOptions& options, RobustPose<N>& result) {
  const PoseProblem& problem = *result.problem;
  const NoiseLevel stated = result.fit->noise;
  const auto shown_by = [&](const PoseMinima<N>& fit) {
    const double freedom = 2 * static_cast<double>(problem.size()) - N;
    return NoiseLevel{std::sqrt(fit.best().cost / freedom), stated.known, false};
  };
  result.residuals = residual_test_of(problem, lens, *result.fit);
  if (result.residuals != ResidualTest::noisy ||
      !(shown_by(*result.fit).sigma_px > stated.sigma_px))
    return;
  std::optional<PoseMinima<N>> fit = pose_minima<N>(problem, lens, options, shown_by(*result.fit));
  if (!fit) {
    result.residuals = ResidualTest::inconsistent;
    return;
  }
  // The second search may find a better pose: then its residuals decide.
  fit->noise = stated;
  result.residuals = residual_test_of(problem, lens, *fit);
  if (result.residuals == ResidualTest::noisy && shown_by(*fit).sigma_px > stated.sigma_px) {
    fit->noise = shown_by(*fit);
    add(result.findings, code::noise_understated,
        understated_sentence(problem, stated, fit->noise.sigma_px));
  }
  fit->prune();
  result.fit = std::move(fit);
}

// Adds a finding if the residuals are spatially correlated. Called if they exceed the known noise,
// or if the noise was estimated from them: a wrong lens or target makes such residuals.
template <int N>
void test_model_error(const Lens& lens, RobustPose<N>& result) {
  const ViewPoints view = result.problem->view();
  ViewResiduals residuals(lens, view);
  residuals.at(result.fit->best().state);
  std::vector<Eigen::Vector2d> differences;
  for (std::size_t i = 0; i < view.size(); ++i)
    differences.push_back(residuals.projected()[i] - view.pixels[i]);
  result.model_error = spatially_correlated(view.pixels, differences);
  if (result.model_error)
    add(result.findings, code::residuals_correlated,
        "the residuals of neighbouring corners are correlated, which noise is not: the lens or the "
        "target is not as stated, and the standard deviations do not include that; calibrate the "
        "lens, or measure the target");
}

// Alternates least-squares fits and the selection of inliers, from the inliers of a consensus until
// they stay the same. Points of a shifted tag stay rejected. With `may_raise`, the inliers of each
// fit may raise the noise (test_and_raise_noise); no fit if they are inconsistent.
template <int N>
RobustPose<N> update_inliers(std::span<const Correspondence> correspondences, const Lens& lens,
                             const PoseOptions& options, std::vector<std::size_t> chosen,
                             const std::set<int>& shifted, bool may_raise) {
  constexpr int kMaxRounds = 10;
  const PoseProblem all(correspondences, options);
  const Pose all_from_target = all.spread().plane_from_target_pose();
  ViewResiduals residuals(lens, all.view());
  RobustPose<N> result;
  const auto is_shifted = [&](std::size_t i) {
    return !shifted.empty() && shifted.contains(options.groups[i]);
  };
  for (int round = 0; round < kMaxRounds; ++round) {
    std::erase_if(chosen, is_shifted);
    result = {};
    result.problem.emplace(correspondences, options, chosen);
    if (const std::string reason = defect(*result.problem); !reason.empty())
      return no_fit<N>(code::no_consensus, "the inliers do not determine a pose: " + reason);
    result.fit = pose_minima<N>(*result.problem, lens, options);
    if (!result.fit) break;
    if (may_raise) test_and_raise_noise(lens, options, result);
    if (may_raise && result.residuals == ResidualTest::inconsistent)
      return no_fit<N>(code::no_consensus, kNoCommonPose);
    result.outliers = complement(chosen, correspondences.size());
    const ViewState& best = result.fit->best().state;
    const Pose camera_from_all = pose_of(best) * result.problem->spread().plane_from_target_pose() *
                                 all_from_target.inverse();
    const std::span<const double> squares = residuals.at(state_of(camera_from_all, best.focal_px));
    std::vector<double> fitted;
    for (const std::size_t i : chosen) fitted.push_back(squares[i]);
    std::vector<std::size_t> next =
        indices_within(squares, largest_inlier_square(result.fit->noise, fitted));
    std::erase_if(next, is_shifted);
    if (next == chosen) break;
    chosen = next;
  }
  return result;
}

// The inliers by the stated noise, and if they raise it, those by the raised one: the stated one
// rejects good points, so that the others show too little. The inliers by the stated noise remain
// if the raised one leads to residuals that are no longer even.
template <int N>
RobustPose<N> fit_inliers(std::span<const Correspondence> correspondences, const Lens& lens,
                          const PoseOptions& options, const std::vector<std::size_t>& chosen,
                          const std::set<int>& shifted) {
  RobustPose<N> result = update_inliers<N>(correspondences, lens, options, chosen, shifted, false);
  if (!result.fit) return result;
  test_and_raise_noise(lens, options, result);
  if (result.residuals != ResidualTest::noisy) return result;
  RobustPose<N> raised =
      update_inliers<N>(correspondences, lens, options,
                        complement(result.outliers, correspondences.size()), shifted, true);
  return raised.fit && raised.residuals == ResidualTest::noisy ? raised : result;
}

// The same, and rejects shifted tags. If they are no minority, the lens or the target is wrong, and
// all stay.
template <int N>
RobustPose<N> fit_without_shifted_tags(std::span<const Correspondence> correspondences,
                                       const Lens& lens, const PoseOptions& options,
                                       const std::vector<std::size_t>& chosen) {
  const RobustPose<N> all = fit_inliers<N>(correspondences, lens, options, chosen, {});
  if (!all.fit || options.groups.empty()) return all;
  const auto groups_of_inliers = [&](const RobustPose<N>& fit) {
    std::vector<int> groups;
    for (const std::size_t i : complement(fit.outliers, options.groups.size()))
      groups.push_back(options.groups[i]);
    return groups;
  };
  std::vector<int> groups = groups_of_inliers(all);
  const std::size_t num_groups = std::set<int>(groups.begin(), groups.end()).size();
  RobustPose<N> result = all;
  std::set<int> shifted;
  while (const auto found =
             shifted_tag<N>(*result.problem, groups, lens, result.fit->best().state)) {
    shifted.insert(*found);
    if (policy::is_above(shifted.size(), policy::kMinority, num_groups)) return all;
    result = fit_inliers<N>(correspondences, lens, options, chosen, shifted);
    if (!result.fit) return all;
    groups = groups_of_inliers(result);
  }
  return result;
}

// True if a second search, from what was rejected, finds another pose with nearly as many inliers.
// Up to half of the first one's inliers may be among them, those in tags with a rejected corner.
// Examples: if all tags are turned by a quarter, the first corners of all tags show the board in
// one place, the second corners in another; if two of four tags have each other's ids, two corners
// of each tag may agree on a turned board.
template <int N>
bool has_rival(std::span<const Correspondence> correspondences, const Lens& lens,
               const PoseOptions& options, const RobustPose<N>& result) {
  const auto is_outlier = [&](std::size_t i) {
    return std::ranges::binary_search(result.outliers, i);
  };
  std::set<int> tags;
  for (const std::size_t i : result.outliers)
    if (!options.groups.empty()) tags.insert(options.groups[i]);
  std::vector<std::size_t> chosen, known;
  std::vector<int> groups;
  for (std::size_t i = 0; i < correspondences.size(); ++i) {
    if (!is_outlier(i) && (tags.empty() || !tags.contains(options.groups[i]))) continue;
    if (!is_outlier(i)) known.push_back(chosen.size());
    if (!tags.empty()) groups.push_back(options.groups[i]);
    chosen.push_back(i);
  }
  const double enough =
      policy::kRivalShare * static_cast<double>(correspondences.size() - result.outliers.size());
  const double share = (enough - static_cast<double>(known.size() / 2)) /
                       static_cast<double>(result.outliers.size());
  if (!(share <= 1)) return false;
  const PoseProblem rest(correspondences, options, chosen);
  const double sigma = result.fit->noise.sigma_px;
  const auto rival = pose_ransac<N>({lens, rest.view(), groups, sigma, options.seed, share, known});
  return rival && static_cast<double>(rival->inliers.size()) >= enough;
}

template <int N>
RobustPose<N> search(std::span<const Correspondence> correspondences, const Lens& lens,
                     const PoseOptions& options) {
  const PoseProblem all(correspondences, options);
  double sigma = options.sigma_px > 0 ? options.sigma_px : policy::kRansacSigmaPx;
  if (all.whitened()) sigma = 1;
  const auto consensus = pose_ransac<N>({lens, all.view(), options.groups, sigma, options.seed});
  if (!consensus) return no_fit<N>(code::no_consensus, kNoCommonPose);
  RobustPose<N> result =
      fit_without_shifted_tags<N>(correspondences, lens, options, consensus->inliers);
  if (!result.fit || result.residuals == ResidualTest::inconsistent)
    return no_fit<N>(code::no_consensus, kNoCommonPose);
  if (has_rival<N>(correspondences, lens, options, result))
    return no_fit<N>(
        code::no_consensus,
        "two groups of points agree on different poses, and neither is clearly larger: "
        "check the ids of the target");
  return result;
}

}  // namespace

template <int N>
RobustPose<N> fit_pose_robustly(std::span<const Correspondence> correspondences, const Lens& lens,
                                const PoseOptions& options) {
  RobustPose<N> result;
  if (const std::string reason = defect(options, correspondences.size()); !reason.empty())
    return no_fit<N>(code::degenerate, reason);
  result.problem.emplace(correspondences, options);
  if (const std::string reason = defect(*result.problem); !reason.empty())
    return no_fit<N>(code::degenerate, reason);
  result.fit = pose_minima<N>(*result.problem, lens, options);
  if (result.fit) test_and_raise_noise(lens, options, result);
  if (result.residuals == ResidualTest::inconsistent) {
    const bool may_search = options.reject_outliers && correspondences.size() > 4;
    if (!may_search && !result.fit)
      return no_fit<N>(code::degenerate, "no pose puts the points in front of the camera");
    if (!may_search)
      return no_fit<N>(code::no_consensus,
                       "the residuals of the best pose are too large or too uneven for noise");
    result = search<N>(correspondences, lens, options);
    if (!result.fit) return result;
  }
  if (result.residuals == ResidualTest::noisy || !result.fit->noise.known)
    test_model_error(lens, result);
  if (result.fit->noise.assumed)
    add(result.findings, code::noise_assumed,
        fmt::format("no noise is stated, and there are too few residuals to estimate it: {} px is "
                    "assumed",
                    policy::kAssumedSigmaPx));
  return result;
}

template RobustPose<6> fit_pose_robustly<6>(std::span<const Correspondence>, const Lens&,
                                            const PoseOptions&);
template RobustPose<7> fit_pose_robustly<7>(std::span<const Correspondence>, const Lens&,
                                            const PoseOptions&);

}  // namespace tagcal::internal
