#include "tagcal/estimate/handeye/handeye_sights.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "tagcal/estimate/calibration/calibration_fit.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

// The noise of the corners without a covariance, by the residuals of all views that have such.
double common_sigma_px(std::span<const SeenView> views, std::vector<Finding>& findings) {
  double square_px2 = 0;
  std::size_t num_corners = 0, num_views = 0;
  for (const SeenView& v : views) {
    if (!is_answer(v.own.status) || !v.covariance_px2.empty()) continue;
    const std::size_t n = v.corners.size() - v.own.outliers.size();
    square_px2 += static_cast<double>(n) * v.own.hypotheses[0].rms_px * v.own.hypotheses[0].rms_px;
    num_corners += n;
    ++num_views;
  }
  return sigma_of_residuals(square_px2, num_corners, num_views, findings);
}

void say_unusable(std::span<const SeenView> views, std::vector<Finding>& findings) {
  const auto has_none = [](const SeenView& v) { return !is_answer(v.own.status); };
  const auto n = std::ranges::count_if(views, has_none);
  if (n == 0) return;
  add(findings, code::view_unusable,
      fmt::format("{} of {} views have no pose of their own and are not used, the first is {}", n,
                  views.size(), std::ranges::find_if(views, has_none)->image));
}

// The point of the board whose place in the camera has the least variances, by the covariances of
// the poses: near the middle of their corners. The step of a point c is tau - [p]x omega with
// p = R c, and its variances sum to tr(C_tt) - 2 p'w + p'G p with G = tr(C_ww) 1 - C_ww and w the
// axial vector of C_wt - C_wt'. Zero without poses.
Eigen::Vector3d best_seen_point(std::span<const SeenView> views) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const SeenView& v : views) {
    if (v.poses.empty()) continue;
    const Eigen::Matrix3d turns = v.poses[0].covariance.topLeftCorner<3, 3>();
    const Eigen::Matrix3d a = v.poses[0].covariance.topRightCorner<3, 3>();
    const Eigen::Vector3d w(a(1, 2) - a(2, 1), a(2, 0) - a(0, 2), a(0, 1) - a(1, 0));
    const Eigen::Matrix3d r = v.poses[0].camera_from_target.rotation_matrix();
    const double trace = turns.trace();
    sum += r.transpose() * (trace * Eigen::Matrix3d::Identity() - turns) * r / trace;
    right += r.transpose() * w / trace;
  }
  if (sum.isZero()) return right;
  return sum.ldlt().solve(right);
}

}  // namespace

HandeyeSights::HandeyeSights(std::vector<SeenView> views, const UncertainCamera& camera,
                             const HandeyeOptions& options, HandeyeEstimate& answer)
    : views_(std::move(views)), options_(options) {
  problem_.mount = options.mount;
  problem_.camera = camera;
  const bool whitened = std::ranges::all_of(
      views_, [](const SeenView& v) { return v.corners.empty() || !v.covariance_px2.empty(); });
  if (!has_corners())
    sigma_px_ = std::nan("");
  else if (options.sigma_px > 0)
    sigma_px_ = options.sigma_px;
  else if (!whitened)
    sigma_px_ = common_sigma_px(views_, answer.findings);
  answer.sigma_px = sigma_px_;
  set_scale();
  say_unusable(views_, answer.findings);
  gather(0);
}

bool HandeyeSights::has_corners() const {
  return std::ranges::any_of(views_, [](const SeenView& v) { return !v.corners.empty(); });
}

void HandeyeSights::set_scale() {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double n = 0;
  for (const SeenView& v : views_)
    for (const Correspondence& c : v.corners) {
      sum += c.point;
      ++n;
    }
  problem_.scale.centre = n > 0 ? Eigen::Vector3d(sum / n) : best_seen_point(views_);
  std::vector<double> distances;
  for (const SeenView& v : views_)
    if (is_answer(v.own.status))
      distances.push_back((v.own.camera_from_target() * problem_.scale.centre).norm());
  if (!distances.empty()) problem_.scale.distance_m = median(distances);
}

void HandeyeSights::gather(double time_offset_s) {
  problem_.sights.clear();
  index_.clear();
  rejected_.clear();
  unusable_.clear();
  for (std::size_t i = 0; i < views_.size(); ++i) {
    auto sight = sight_of(views_[i], time_offset_s);
    if (!sight) {
      unusable_.push_back(i);
      continue;
    }
    problem_.sights.push_back(*std::move(sight));
    index_.push_back(i);
  }
}

void HandeyeSights::keep(std::span<const std::uint8_t> takes_part) {
  std::vector<HandeyeSight> sights;
  std::vector<std::size_t> index;
  for (std::size_t i = 0; i < index_.size(); ++i) {
    if (!takes_part[i]) {
      rejected_.push_back(index_[i]);
      continue;
    }
    sights.push_back(std::move(problem_.sights[i]));
    index.push_back(index_[i]);
  }
  problem_.sights = std::move(sights);
  index_ = std::move(index);
}

std::string HandeyeSights::why_unusable() const {
  std::map<std::string, std::pair<int, std::string>> reasons;  // by code
  for (const std::size_t i : unusable_) {
    const std::vector<Finding>& findings = views_[i].own.findings;
    const auto refusal = std::ranges::find_if(findings, is_refusal);
    if (refusal == findings.end()) continue;
    auto& [count, sentence] = reasons[refusal->code];
    if (++count == 1) sentence = refusal->sentence;
  }
  const auto most =
      std::ranges::max_element(reasons, {}, [](const auto& reason) { return reason.second.first; });
  return most == reasons.end() ? std::string() : most->second.second;
}

std::vector<HandeyePair> HandeyeSights::pairs() const {
  std::vector<HandeyePair> pairs;
  for (const HandeyeSight& s : problem_.sights)
    pairs.push_back({s.own[0].camera_from_target, s.base_from_hand, s.rotation_numbers});
  return pairs;
}

std::optional<HandeyeSight> HandeyeSights::sight_of(const SeenView& view,
                                                    double time_offset_s) const {
  if (!is_answer(view.own.status)) return std::nullopt;
  HandeyeSight sight;
  sight.base_from_hand = view.base_from_hand;
  sight.rotation_numbers = view.rotation_numbers;
  if (options_.path) {
    constexpr double kStep = 1e-3;  // numeric: s, of a difference
    const double time = *view.time_s + time_offset_s;
    const auto here = hand_at(*options_.path, time);
    const auto before = hand_at(*options_.path, time - kStep);
    const auto after = hand_at(*options_.path, time + kStep);
    if (!here || !before || !after) return std::nullopt;
    sight.base_from_hand = *here;
    sight.velocity = minus(*after, *before) / (2 * kStep);
  }
  const bool whitened = !view.covariance_px2.empty() && !(options_.sigma_px > 0);
  if (!view.poses.empty()) {
    sight.own.assign(view.poses.begin(), view.poses.end());
    return sight;
  }
  // Residuals that contradict the corners' covariances raise them (fit_pose_robustly).
  sight.corners = whitened ? inlier_view(view.corners, view.covariance_px2, view.own.outliers,
                                         std::max(1.0, view.own.sigma_px))
                           : inlier_view(view.corners, {}, view.own.outliers, sigma_px_);
  for (const PoseHypothesis& h : view.own.hypotheses)
    sight.own.push_back({h.camera_from_target, h.noise_covariance});
  return sight;
}

}  // namespace tagcal::internal
