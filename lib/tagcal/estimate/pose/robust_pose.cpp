#include "tagcal/estimate/pose/robust_pose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tagcal/estimate/pose/pose_defect.hpp"
#include "tagcal/estimate/pose/pose_ransac.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"
#include "tagcal/estimate/pose/shifted_tag_test.hpp"

namespace tagcal::internal {
namespace {

template <int N>
AgreeingFit<N> no_fit(Status status, const std::string& reason) {
  AgreeingFit<N> result;
  result.status = status;
  result.warnings.push_back(reason);
  return result;
}

// Of two groups that agree on different poses: the share of the one in the other from which on
// neither is more right.
constexpr double kNearlyAsMany = 0.8;

template <int N>
Agreement agreement_of(const PoseProblem& problem, const Lens& lens, const ViewFit<N>& fit) {
  // What the sum of all squares allows, no single one can exceed.
  const double variance = fit.noise.sigma_px * fit.noise.sigma_px;
  if (fit.best().cost <= kOutlierSigmas * kOutlierSigmas * variance) return Agreement::full;
  ViewResiduals residuals(lens, problem.view());
  return agreement(problem, fit.noise, residuals.at(fit.best().state), N);
}

template <int N>
void raise_noise(AgreeingFit<N>& result) {
  NoiseLevel& noise = result.fit->noise;
  const double freedom = 2 * static_cast<double>(result.problem->size()) - N;
  const double sigma = std::sqrt(result.fit->best().cost / freedom);
  if (!(sigma > noise.sigma_px)) return;
  result.warnings.push_back(
      fmt::format("the residuals are {:.1f} times as large as the noise that is {}: the covariance "
                  "counts with {:.2g} px",
                  sigma / noise.sigma_px, noise.assumed ? "assumed" : "stated", sigma));
  noise.sigma_px = sigma;
  noise.assumed = false;
}

// Residuals that are larger than noise that is known, or noise that only they show, may be the
// model's error.
template <int N>
void look_for_model_error(const Lens& lens, AgreeingFit<N>& result) {
  const ViewPoints view = result.problem->view();
  ViewResiduals residuals(lens, view);
  residuals.at(result.fit->best().state);
  std::vector<Eigen::Vector2d> differences;
  for (std::size_t i = 0; i < view.size(); ++i)
    differences.push_back(residuals.projected()[i] - view.pixels[i]);
  result.model_error = go_together(view.pixels, differences);
  if (result.model_error)
    result.warnings.emplace_back(
        "the residuals go together from corner to corner, as noise does not: the lens bends lines, "
        "or the target is not as stated, and the standard deviations do not count with that");
}

// From the inliers of a consensus to the least-squares fit of all that agree with it and are of no
// group that was found odd.
template <int N>
AgreeingFit<N> settle(std::span<const Correspondence> correspondences, const Lens& lens,
                      const PoseOptions& options, std::vector<std::size_t> chosen,
                      const std::set<int>& odd) {
  constexpr int kMaxRounds = 10;
  const PoseProblem all(correspondences, options);
  const Pose all_from_target = all.spread().plane_from_target_pose();
  ViewResiduals residuals(lens, all.view());
  AgreeingFit<N> result;
  const auto is_odd = [&](std::size_t i) {
    return !odd.empty() && odd.contains(options.groups[i]);
  };
  for (int round = 0; round < kMaxRounds; ++round) {
    std::erase_if(chosen, is_odd);
    result.problem.emplace(correspondences, options, chosen);
    if (const std::string reason = defect(*result.problem); !reason.empty())
      return no_fit<N>(Status::no_consensus, "of the points that agree: " + reason);
    result.fit = fit_view<N>(*result.problem, lens, options);
    if (!result.fit) break;
    result.outliers = others(chosen, correspondences.size());
    const ViewState& best = result.fit->best().state;
    const Pose camera_from_all = pose_of(best) * result.problem->spread().plane_from_target_pose() *
                                 all_from_target.inverse();
    std::vector<std::size_t> next =
        within(residuals.at(state_of(camera_from_all, best.focal_px)), result.fit->noise.sigma_px);
    std::erase_if(next, is_odd);
    if (next == chosen) break;
    chosen = next;
  }
  return result;
}

// The groups of the correspondences that a fit kept.
template <int N>
std::vector<int> groups_kept(const AgreeingFit<N>& result, const PoseOptions& options) {
  std::vector<int> groups;
  for (const std::size_t i : others(result.outliers, options.groups.size()))
    groups.push_back(options.groups[i]);
  return groups;
}

// The same, and without the groups that do not go with the others: of more than a third of them it
// is the lens or the target that does not, and all stay.
template <int N>
AgreeingFit<N> settle_without_odd(std::span<const Correspondence> correspondences, const Lens& lens,
                                  const PoseOptions& options,
                                  const std::vector<std::size_t>& chosen) {
  const AgreeingFit<N> all = settle<N>(correspondences, lens, options, chosen, {});
  if (!all.fit || options.groups.empty()) return all;
  std::vector<int> groups = groups_kept(all, options);
  const std::size_t most = std::set<int>(groups.begin(), groups.end()).size() / 3;
  AgreeingFit<N> result = all;
  for (std::set<int> odd;;) {
    const auto found = odd_group<N>(*result.problem, groups, lens, result.fit->best().state);
    if (!found) return result;
    odd.insert(*found);
    if (odd.size() > most) return all;
    result = settle<N>(correspondences, lens, options, chosen, odd);
    if (!result.fit) return all;
    groups = groups_kept(result, options);
  }
}

// Whether a pose of one group, none of whose corners was kept or not all, has nearly as many that
// agree with it. (Of four tags two with each other's ids: two corners of each of the four may agree
// on the board turned by half a turn, as many as are right.) That is asked of a few inliers only:
// many agree for no such reason.
template <int N>
bool has_rival_group(std::span<const Correspondence> correspondences, const Lens& lens,
                     const PoseOptions& options, const AgreeingFit<N>& result) {
  constexpr std::size_t kFew = 16;
  const std::size_t inliers = correspondences.size() - result.outliers.size();
  if (N == 7 || options.groups.empty() || inliers > kFew) return false;
  std::map<int, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < correspondences.size(); ++i) groups[options.groups[i]].push_back(i);
  const PoseProblem all(correspondences, options);
  const Pose all_from_target = all.spread().plane_from_target_pose();
  ViewResiduals residuals(lens, all.view());
  const auto is_outlier = [&](std::size_t i) {
    return std::binary_search(result.outliers.begin(), result.outliers.end(), i);
  };
  for (const auto& [id, members] : groups) {
    const bool kept = std::none_of(members.begin(), members.end(), is_outlier);
    const PoseProblem group(correspondences, options, members);
    if (kept || !defect(group).empty()) continue;
    const auto fit = fit_view<6>(group, lens, options);
    for (std::size_t i = 0; fit && i < fit->poses.size(); ++i) {
      const Pose camera_from_all = pose_of(fit->poses[i].state) *
                                   group.spread().plane_from_target_pose() *
                                   all_from_target.inverse();
      // A pose of one tag is wide of the other corners by some times the noise.
      const std::vector<std::size_t> agree =
          within(residuals.at(state_of(camera_from_all)), 4 * result.fit->noise.sigma_px);
      // With nearly all that were kept it is the same pose, and the group a little off.
      const auto same =
          std::count_if(agree.begin(), agree.end(), [&](std::size_t k) { return !is_outlier(k); });
      const double enough = kNearlyAsMany * static_cast<double>(inliers);
      if (static_cast<double>(same) < enough && static_cast<double>(agree.size()) >= enough)
        return true;
    }
  }
  return false;
}

// Whether those that were left out agree on a pose of their own nearly as well: then neither is
// more right than the other. (All tags turned by a quarter: each of the four corners of all tags
// is the board in another place.)
template <int N>
bool has_rival(std::span<const Correspondence> correspondences, const Lens& lens,
               const PoseOptions& options, const AgreeingFit<N>& result) {
  const auto inliers = static_cast<double>(correspondences.size() - result.outliers.size());
  const double share = kNearlyAsMany * inliers / static_cast<double>(result.outliers.size());
  if (!(share <= 1)) return false;
  const PoseProblem rest(correspondences, options, result.outliers);
  std::vector<int> groups;
  if (!options.groups.empty())
    for (const std::size_t i : result.outliers) groups.push_back(options.groups[i]);
  const double sigma = result.fit->noise.sigma_px;
  const auto rival =
      find_view_consensus<N>({lens, rest.view(), groups, sigma, options.seed, share});
  return rival && static_cast<double>(rival->inliers.size()) >= kNearlyAsMany * inliers;
}

template <int N>
AgreeingFit<N> search(std::span<const Correspondence> correspondences, const Lens& lens,
                      const PoseOptions& options) {
  const PoseProblem all(correspondences, options);
  constexpr double kUsualSigmaPx = 1;  // where none is stated; what is found then shows its own
  double sigma = options.sigma_px > 0 ? options.sigma_px : kUsualSigmaPx;
  if (all.whitened()) sigma = 1;
  const auto consensus =
      find_view_consensus<N>({lens, all.view(), options.groups, sigma, options.seed});
  const std::string reason = "the points do not agree on one pose";
  if (!consensus) return no_fit<N>(Status::no_consensus, reason);
  AgreeingFit<N> result = settle_without_odd<N>(correspondences, lens, options, consensus->inliers);
  if (!result.fit || agreement_of(*result.problem, lens, *result.fit) == Agreement::partly)
    return no_fit<N>(Status::no_consensus, reason);
  if (has_rival<N>(correspondences, lens, options, result) ||
      has_rival_group<N>(correspondences, lens, options, result))
    return no_fit<N>(Status::no_consensus,
                     "two groups of points agree on different poses, and neither is larger");
  return result;
}

}  // namespace

template <int N>
AgreeingFit<N> fit_agreeing(std::span<const Correspondence> correspondences, const Lens& lens,
                            const PoseOptions& options) {
  AgreeingFit<N> result;
  if (const std::string reason = defect(options, correspondences.size()); !reason.empty())
    return no_fit<N>(Status::degenerate, reason);
  result.problem.emplace(correspondences, options);
  if (const std::string reason = defect(*result.problem); !reason.empty())
    return no_fit<N>(Status::degenerate, reason);
  result.fit = fit_view<N>(*result.problem, lens, options);
  Agreement agreement =
      result.fit ? agreement_of(*result.problem, lens, *result.fit) : Agreement::partly;
  if (agreement == Agreement::partly) {
    const bool may_search = options.reject_outliers && correspondences.size() > 4;
    if (!may_search && !result.fit)
      return no_fit<N>(Status::degenerate, "no pose puts the points in front of the camera");
    if (!may_search)
      return no_fit<N>(Status::no_consensus, "the residuals of the best pose are not noise");
    result = search<N>(correspondences, lens, options);
    if (!result.fit) return result;
    agreement = agreement_of(*result.problem, lens, *result.fit);
  }
  if (agreement == Agreement::noisy) raise_noise(result);
  if (agreement == Agreement::noisy || !result.fit->noise.known) look_for_model_error(lens, result);
  if (result.fit->noise.assumed)
    result.warnings.emplace_back(
        "no noise is stated and the residuals are too few to show it: 0.5 px is assumed");
  return result;
}

template AgreeingFit<6> fit_agreeing<6>(std::span<const Correspondence>, const Lens&,
                                        const PoseOptions&);
template AgreeingFit<7> fit_agreeing<7>(std::span<const Correspondence>, const Lens&,
                                        const PoseOptions&);

}  // namespace tagcal::internal
