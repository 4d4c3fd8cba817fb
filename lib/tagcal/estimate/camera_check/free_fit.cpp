#include "tagcal/estimate/camera_check/free_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/model_error.hpp"
#include "tagcal/estimate/camera_check/free_start.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/check_policy.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

// The covariance of a corner is scale^2 (C + error_px^2 I), with C its own one, or the identity.
struct CornerScale {
  double scale = 1;
  double error_px = 0;
};

// The robust fit of the free cameras.
class Fitting {
 public:
  Fitting(const RigDataset& data, const KnownRig& known, const CheckOptions& options,
          std::vector<Finding>& findings)
      : data_(data), known_(known), options_(options), findings_(findings) {}

  std::optional<FreeFit> run() {
    read_views();
    if (!place_views()) return std::nullopt;
    constexpr int kRounds = 10;  // numeric: a limit of work
    for (int round = 0; round < kRounds; ++round) {
      if (round > 0) reject_views();
      take_inliers();
      solve(fit_.state.cameras, fit_.state.poses, options_.max_iterations, options_.num_threads);
      if (!update_noise(round)) break;
    }
    for (std::size_t c = 0; c < views_.size(); ++c) describe(c);
    if (num_instants() == 0) return std::nullopt;
    return std::move(fit_);
  }

 private:
  void read_views() {
    for (std::size_t c = 0; c < known_.cameras.size(); ++c) {
      const Dataset& data = data_.cameras[c].data;
      CalibrationInput input = calibration_input(data, {});
      findings_.insert(findings_.end(), input.findings.begin(), input.findings.end());
      views_.push_back(whole_views(input, known_.cameras[c].camera.camera, findings_));
      has_covariances_.push_back(input.whitened);
      fit_.state.cameras.push_back(free_bundle(known_.cameras[c].camera, data));
      fit_.cameras.push_back({known_.cameras[c].name, 0, 0, 0, 0, 0});
      fit_.strain.push_back(0);
    }
    scale_.resize(views_.size());
  }

  // The instant of each view, in the frame of the rig; views without one are alone. False without
  // views.
  bool place_views() {
    LinkedPoses& poses = fit_.state.poses;
    poses.reference = known_.reference().value_or(0);
    poses.world_from_board = {Pose()};
    for (const KnownRig::Member& member : known_.cameras)
      poses.camera_from_rig.push_back(member.camera_from_rig);
    std::vector<std::optional<std::size_t>> number(data_.instants.size());
    for (std::size_t c = 0; c < views_.size(); ++c) {
      poses.links.emplace_back();
      for (const WholeView& view : views_[c]) {
        const auto at = std::ranges::find_if(
            data_.instants, [&](const Instant& instant) { return instant.view[c] == view.index; });
        std::optional<std::size_t> alone;
        auto& instant = at == data_.instants.end()
                            ? alone
                            : number[static_cast<std::size_t>(at - data_.instants.begin())];
        if (!instant) {
          instant = poses.rig_from_world.size();
          poses.rig_from_world.push_back(poses.camera_from_rig[c].inverse() * *view.pose);
        }
        poses.links[c].push_back({*instant, 0, {}});
      }
    }
    connect();
    return !poses.rig_from_world.empty();
  }

  // Cameras are connected with the reference by common instants.
  void connect() {
    const LinkedPoses& poses = fit_.state.poses;
    fit_.connected = {std::vector<std::uint8_t>(views_.size()), {1}};
    fit_.connected.cameras[poses.reference] = 1;
    const auto meets = [&](std::size_t a, std::size_t b) {
      return std::ranges::any_of(poses.links[a], [&](const LinkedPoses::Link& link) {
        return std::ranges::count(poses.links[b], link.instant, &LinkedPoses::Link::instant) > 0;
      });
    };
    for (std::size_t round = 0; round < views_.size(); ++round)
      for (std::size_t a = 0; a < views_.size(); ++a)
        for (std::size_t b = 0; b < views_.size(); ++b)
          if (fit_.connected.cameras[a] && meets(a, b)) fit_.connected.cameras[b] = 1;
  }

  // Views of which too few corners are inliers of the free camera.
  void reject_views() {
    for (std::size_t c = 0; c < views_.size(); ++c)
      for (std::size_t v = views_[c].size(); v-- > 0;) {
        const WholeView& view = views_[c][v];
        const auto num = static_cast<double>(std::ranges::count(view.inlier, 1));
        if (num >= policy::kLeastViewCorners &&
            num >= policy::kLeastInlierShare * static_cast<double>(view.inlier.size()))
          continue;
        add(findings_, code::view_rejected,
            data_.cameras[c].data.views[view.index].image +
                ": not used, most of its corners contradict the other pictures: the board moved, "
                "or it is not the board of the target file");
        views_[c].erase(views_[c].begin() + static_cast<std::ptrdiff_t>(v));
        auto& links = fit_.state.poses.links[c];
        links.erase(links.begin() + static_cast<std::ptrdiff_t>(v));
      }
  }

  Matrix2 covariance(std::size_t c, const Matrix2& own) const {
    const CornerScale& s = scale_[c];
    return s.scale * s.scale * (own + s.error_px * s.error_px * Matrix2::Identity());
  }

  void take_inliers() {
    for (std::size_t c = 0; c < views_.size(); ++c) {
      Bundle& bundle = fit_.state.cameras[c];
      bundle.views.clear();
      bundle.camera_from_target.clear();
      for (std::size_t v = 0; v < views_[c].size(); ++v) {
        const WholeView& view = views_[c][v];
        ViewProblem problem;
        for (std::size_t i = 0; i < view.corners.size(); ++i) {
          if (!view.inlier[i]) continue;
          problem.correspondences.push_back(view.corners[i]);
          problem.whitening.push_back(whitening_of(covariance(c, view.covariance_px2[i])));
        }
        bundle.views.push_back(std::move(problem));
        bundle.camera_from_target.push_back(
            fit_.state.poses.camera_from_board(c, fit_.state.poses.links[c][v]));
      }
      bundle.row_terms.assign(bundle.views.size(), Vector6d::Zero());
    }
  }

  // Residuals in px of all corners of a view, by the state.
  std::vector<Vector2d> residuals_of(std::size_t c, std::size_t v) const {
    const Bundle& bundle = fit_.state.cameras[c];
    ViewProblem whole, buffer;
    whole.correspondences.own() = views_[c][v].corners;
    return residuals_px(bundle.corrected(whole, bundle.row_terms[v], buffer).correspondences,
                        bundle.lens(), bundle.camera_from_target[v]);
  }

  // Sets inliers, noise and row terms by the residuals. False if they stay as they are.
  bool update_noise(int round) {
    bool changed = false;
    int num_residuals = 0, num_parameters = 6 * static_cast<int>(num_instants());
    for (std::size_t c = 0; c < views_.size(); ++c) {
      num_residuals += 2 * num_inliers(c);
      num_parameters += fit_.state.cameras[c].model->num_free();
    }
    num_parameters += fit_.state.cameras.front().num_shapes();
    for (const std::uint8_t is_connected : fit_.connected.cameras)
      num_parameters += is_connected ? 6 : 0;
    num_parameters -= 6;  // of the reference
    fit_.freedom = std::max(1, num_residuals - num_parameters);
    const double share = fit_.freedom / std::max(1, num_residuals);
    for (std::size_t c = 0; c < views_.size(); ++c) changed |= update_camera(c, share, round);
    return changed;
  }

  bool update_camera(std::size_t c, double freedom_share, int round) {
    std::vector<std::vector<Vector2d>> residuals;
    std::vector<double> squares;
    for (std::size_t v = 0; v < views_[c].size(); ++v) {
      residuals.push_back(residuals_of(c, v));
      for (std::size_t i = 0; i < residuals[v].size(); ++i) {
        const Matrix2 w = whitening_of(covariance(c, views_[c][v].covariance_px2[i]));
        const double square = (w * residuals[v][i]).squaredNorm();
        squares.push_back(std::isfinite(square) ? square : std::numeric_limits<double>::infinity());
      }
    }
    if (squares.empty()) return false;
    const double bound = policy::kOutlierSigmas * policy::kOutlierSigmas *
                         std::max(robust_variance(squares), std::numeric_limits<double>::min());
    bool changed = false;
    std::vector<Vector2d> used;
    std::vector<Matrix2> covariances;
    auto square = squares.begin();
    for (std::size_t v = 0; v < views_[c].size(); ++v) {
      WholeView& view = views_[c][v];
      for (std::size_t i = 0; i < view.corners.size(); ++i, ++square) {
        const bool is_inlier = *square <= bound;
        changed |= is_inlier != (view.inlier[i] != 0);
        view.inlier[i] = is_inlier;
        if (!is_inlier) continue;
        used.push_back(residuals[v][i]);
        covariances.push_back(view.covariance_px2[i]);
      }
    }
    const CornerScale before = scale_[c];
    scale_[c] = scale_of(c, used, covariances, freedom_share);
    Bundle& bundle = fit_.state.cameras[c];
    if (round == 0 && std::ssize(bundle.views) >= policy::kFewestTellingViews)
      bundle.row_sigma = row_sigma_of(bundle, scale_[c].scale / before.scale);
    changed |= bundle.row_sigma > 0 && round == 0;
    return changed || std::abs(scale_[c].scale - before.scale) > kSettled * before.scale ||
           std::abs(scale_[c].error_px - before.error_px) > kSettled * before.error_px;
  }

  CornerScale scale_of(std::size_t c, std::span<const Vector2d> residuals,
                       std::span<const Matrix2> covariances, double freedom_share) const {
    const double freedom = 2 * freedom_share * static_cast<double>(residuals.size());
    CornerScale scale;
    if (has_covariances_[c])
      scale.error_px = std::max(policy::kLeastSigmaPx, excess_px(residuals, covariances, freedom));
    double sum = 0;
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const Matrix2 all = covariances[i] + scale.error_px * scale.error_px * Matrix2::Identity();
      sum += (whitening_of(all) * residuals[i]).squaredNorm();
    }
    scale.scale = std::max(policy::kLeastSigmaPx, std::sqrt(sum / freedom));
    return scale;
  }

  int num_inliers(std::size_t c) const {
    std::ptrdiff_t count = 0;
    for (const WholeView& view : views_[c]) count += std::ranges::count(view.inlier, 1);
    return static_cast<int>(count);
  }

  // Those with a view.
  std::size_t num_instants() const {
    std::set<std::size_t> instants;
    for (const auto& links : fit_.state.poses.links)
      for (const LinkedPoses::Link& link : links) instants.insert(link.instant);
    return instants.size();
  }

  // The noise of the inliers under the free camera, and their RMS under the free and the known one.
  void describe(std::size_t c) {
    CheckedCamera& camera = fit_.cameras[c];
    const Bundle& bundle = fit_.state.cameras[c];
    double shared = 0, free = 0, held = 0, held_flat = 0;
    for (std::size_t v = 0; v < bundle.views.size(); ++v) {
      ViewProblem buffer;
      const ViewProblem& seen = bundle.corrected(v, buffer);
      ++camera.num_views;
      camera.num_corners += static_cast<int>(seen.correspondences.size());
      const Pose& of_rig = bundle.camera_from_target[v];
      const auto squares = [](const ViewProblem& corners, const Lens& lens, const Pose& pose) {
        double sum = 0;
        for (const Vector2d& r : residuals_px(corners.correspondences, lens, pose))
          sum += r.squaredNorm();
        return sum;
      };
      const auto own_squares = [&](const ViewProblem& corners, const Lens& lens) {
        const auto pose = refine_view_pose(corners, lens, *views_[c][v].pose);
        return squares(corners, lens, pose ? pose->camera_from_target : of_rig);
      };
      const Lens& known = known_.cameras[c].camera.camera.lens;
      shared += squares(seen, bundle.lens(), of_rig);
      free += own_squares(seen, bundle.lens());
      held += own_squares(seen, known);
      held_flat += own_squares(bundle.views[v], known);
    }
    if (camera.num_corners == 0) return;
    if (held > 0) fit_.strain[c] = std::sqrt(shared / held);
    camera.rms_px = std::sqrt(free / camera.num_corners);
    // The shape of the board was found with the free lens, and may fit no other one.
    camera.known_rms_px = std::sqrt(std::min(held, held_flat) / camera.num_corners);
    int all = 0;
    for (const Bundle& other : fit_.state.cameras) all += num_corners(other);
    camera.sigma_px =
        std::sqrt(shared / camera.num_corners) / std::sqrt(static_cast<double>(fit_.freedom) / all);
  }

  static constexpr double kSettled = 1e-3;  // numeric: share of a noise that changes no test

  const RigDataset& data_;
  const KnownRig& known_;
  const CheckOptions& options_;
  std::vector<Finding>& findings_;
  std::vector<std::vector<WholeView>> views_;
  std::vector<std::uint8_t> has_covariances_;
  std::vector<CornerScale> scale_;
  FreeFit fit_;
};

}  // namespace

std::optional<FreeFit> fit_freely(const RigDataset& data, const KnownRig& known,
                                  const CheckOptions& options, std::vector<Finding>& findings) {
  return Fitting(data, known, options, findings).run();
}

}  // namespace tagcal::internal
