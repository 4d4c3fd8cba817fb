#include "tagcal/estimate/pose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/error.hpp"
#include "tagcal/estimate/bundle/held_lens.hpp"
#include "tagcal/estimate/bundle/lens_prior.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/pose_hypotheses.hpp"
#include "tagcal/estimate/pose/robust_pose.hpp"
#include "tagcal/estimate/pose/view_checks.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal {
using namespace internal;
namespace {

// The only place that judges a pose: by its findings and the number of its hypotheses.
template <typename Estimate>
Estimate judged(Estimate estimate) {
  estimate.status = judge(estimate.findings);
  if (estimate.status == Status::ok && estimate.hypotheses.size() > 1)
    estimate.status = Status::ambiguous;
  return estimate;
}

// Copies what poses with and without a focal length report of a fit.
template <int N, typename Estimate>
RobustPose<N> fitted(std::span<const Correspondence> correspondences, const Lens& lens,
                     const PoseOptions& options, Estimate& estimate,
                     Eigen::Matrix<double, N, N, Eigen::DontAlign>* covariance = nullptr) {
  RobustPose<N> robust = fit_pose_robustly<N>(correspondences, lens, options);
  estimate.findings = std::move(robust.findings);
  if (!robust.fit) return robust;
  estimate.outliers = std::move(robust.outliers);
  estimate.sigma_px = robust.fit->noise.sigma_px;
  estimate.hypotheses = hypotheses_of<N>(*robust.problem, lens, *robust.fit, covariance);
  return robust;
}

// The inliers with a noise of 1.
ViewProblem inliers_of(std::span<const Correspondence> correspondences, const PoseOptions& options,
                       const auto& estimate) {
  return inlier_view(correspondences, options.covariance_px2, estimate.outliers,
                     std::max(estimate.sigma_px, kLeastPoseSigmaPx));
}

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// Adds the steps of the poses by the error of the lens to their covariances.
void add_lens_error(std::span<const Correspondence> correspondences, const PoseOptions& options,
                    const UncertainCamera& camera, PoseEstimate& estimate) {
  const ViewProblem view = inliers_of(correspondences, options, estimate);
  for (PoseHypothesis& h : estimate.hypotheses) {
    const auto response = lens_response(view, camera, h.camera_from_target, false);
    if (response)
      h.covariance += response->by_lens * camera.covariance * response->by_lens.transpose();
    else
      h.covariance.setConstant(kUnknown);
  }
}

// The same of what a lens can be instead of a pinhole, as far as the view does not exclude it.
void add_error_of_pinhole(std::span<const Correspondence> correspondences, const ImageSize& size,
                          const PoseOptions& options, PoseAndFocalEstimate& estimate) {
  const ViewProblem view = inliers_of(correspondences, options, estimate);
  for (PoseHypothesis& h : estimate.hypotheses) {
    const UncertainCamera lens = usual_lens(h.focal_px, size);
    const auto response = lens_response(view, lens, h.camera_from_target, true);
    Matrix7 share = Matrix7::Constant(kUnknown);
    if (response)
      share = response->by_lens * learned_covariance(*response, lens.covariance) *
              response->by_lens.transpose();
    h.covariance += share.topLeftCorner<6, 6>();
    if (&h == &estimate.hypotheses.front()) estimate.covariance += share;
  }
}

// Refuses the pose of a solver that stopped at no minimum.
template <int N>
void check_convergence(const PoseMinima<N>& fit, std::vector<Finding>& findings) {
  if (!fit.best().converged)
    add(findings, code::not_converged,
        "the solver stopped before it reached a minimum: allow more iterations");
}

// True for points so near to a line that the data do not exclude a turn by 20 degrees about it. The
// linear covariance does not show this: the likelihood along the turn is flat, and noise decides
// where its minima are.
bool is_turn_about_line_unknown(const PoseProblem& problem, const Lens& lens,
                                const PoseMinima<6>& fit) {
  const ViewPoints view = problem.view();
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : view.points) squares += p.cwiseAbs2();
  Eigen::Index along = 0;
  const double length = squares.maxCoeff(&along), width = squares.sum() - length;
  if (width > policy::kNarrowWidth * policy::kNarrowWidth * length) return false;
  ViewResiduals residuals(lens, view);
  const double variance = fit.noise.sigma_px * fit.noise.sigma_px;
  for (const double turn : {policy::kLineTurnRad, -policy::kLineTurnRad}) {
    ViewState state = fit.best().state;
    state.rotation =
        state.rotation * exp_rotation(turn * Eigen::Vector3d::Unit(along)).toRotationMatrix();
    double cost = 0;
    for (const double square : residuals.at(state)) cost += square;
    if (cost - fit.best().cost < policy::kExcludedCost * variance) return true;
  }
  return false;
}

Lens plain_pinhole(double focal_px, const ImageSize& size) {
  const Eigen::Vector2d centre = image_centre(size);
  return pinhole(focal_px, focal_px, centre.x(), centre.y());
}

// Returns by how many sigma^2 weak perspective (an infinite focal length) fits worse. With
// covariances this is an upper bound: the weak-perspective fit does not weight the pixels.
double weak_perspective_excess(const PoseProblem& problem, const PoseMinima<7>& fit,
                               const Solutions<WeakPerspectivePose, 2>& weak,
                               const Eigen::Vector2d& centre) {
  if (weak.empty()) return std::numeric_limits<double>::infinity();
  const ViewPoints view = problem.view();
  const WeakPerspectivePose& best = weak.front();
  double cost = 0;
  for (std::size_t i = 0; i < view.size(); ++i) {
    const Eigen::Vector3d x = best.camera_from_target * view.points[i];
    Eigen::Vector2d residual = best.scale_px_per_m * x.head<2>() + centre - view.pixels[i];
    if (problem.whitened()) residual = view.whitening[i] * residual;
    cost += residual.squaredNorm();
  }
  return (cost - fit.best().cost) / (fit.noise.sigma_px * fit.noise.sigma_px);
}

// Weak-perspective poses in the target's frame.
std::vector<WeakPerspectivePose> in_target_frame(const PoseProblem& problem,
                                                 const Solutions<WeakPerspectivePose, 2>& poses) {
  std::vector<WeakPerspectivePose> result;
  for (WeakPerspectivePose pose : poses) {
    pose.camera_from_target = pose.camera_from_target * problem.spread().plane_from_target_pose();
    const Eigen::Vector3d t = pose.camera_from_target.translation();
    pose.camera_from_target =
        Pose(pose.camera_from_target.rotation(), Eigen::Vector3d(t.x(), t.y(), 0));
    result.push_back(pose);
  }
  return result;
}

Solutions<WeakPerspectivePose, 2> weak_poses(const PoseProblem& problem,
                                             const Eigen::Vector2d& centre) {
  InlineBuffer<Eigen::Vector2d, 8> pixels(problem.size());
  for (std::size_t i = 0; i < problem.size(); ++i) pixels[i] = problem.view().pixels[i] - centre;
  return weak_perspective_poses(problem.view().points, pixels.span());
}

// Adds the poses for the prior focal length.
void add_poses_of_prior(std::span<const Correspondence> correspondences, const ImageSize& size,
                        const PoseAndFocalOptions& options, PoseAndFocalEstimate& estimate) {
  const PoseEstimate prior =
      estimate_pose(correspondences, {plain_pinhole(options.prior_focal_px, size), size}, options);
  // The noise is now that of these poses.
  if (is_answer(prior.status))
    std::erase_if(estimate.findings, [](const Finding& f) {
      return f.code == code::noise_understated.name || f.code == code::noise_assumed.name;
    });
  estimate.findings.insert(estimate.findings.end(), prior.findings.begin(), prior.findings.end());
  if (!is_answer(prior.status)) return;
  estimate.hypotheses = prior.hypotheses;
  estimate.outliers = prior.outliers;
  estimate.sigma_px = prior.sigma_px;
}

// Describes an invalid image size or option; empty if both are valid.
std::string defect(const ImageSize& size, const PoseAndFocalOptions& options) {
  if (size.width <= 0 || size.height <= 0) return "the image has no size";
  if (!(options.prior_focal_px >= 0) || std::isinf(options.prior_focal_px))
    return "the prior focal length must be 0 (none) or more, and finite";
  return {};
}

// Sentence for a refused focal length. `of_noise`: its relative standard deviation if the lens is a
// pinhole.
std::string refusal(double relative_sigma, double of_noise, bool model_error) {
  if (of_noise <= policy::kFocalRefused && relative_sigma > policy::kFocalRefused && !model_error)
    return fmt::format(
        "the view does not separate the focal length from the principal point and the distortion, "
        "which are not known (standard deviation of the focal length {:.0f} %, of an exact pinhole "
        "{:.1f} %): calibrate from several views",
        100 * relative_sigma, 100 * of_noise);
  if (relative_sigma > policy::kFocalRefused && std::isfinite(relative_sigma))
    return fmt::format(
        "the view does not separate the focal length from the distance (standard deviation of the "
        "focal length {:.0f} %): come nearer, or tilt the target by 30 degrees or more",
        100 * relative_sigma);
  return model_error ? "the residuals show that the lens is no pinhole: calibrate the lens"
                     : "the view does not separate the focal length from the distance (weak "
                       "perspective explains it as well): come nearer, or tilt the target by 30 "
                       "degrees or more";
}

// Returns true if the focal length is observable. `weak` becomes the poses under weak perspective
// if the decision needs them.
bool is_focal_observable(const RobustPose<7>& robust, double relative_sigma,
                         const Eigen::Vector2d& centre, Solutions<WeakPerspectivePose, 2>& weak) {
  const bool by_sigma = relative_sigma <= policy::kFocalRefused && !robust.model_error;
  if (by_sigma && relative_sigma <= policy::kFocalWellKnown) return true;
  weak = weak_poses(*robust.problem, centre);
  return by_sigma && weak_perspective_excess(*robust.problem, *robust.fit, weak, centre) >=
                         chi_square_quantile(1, policy::kQuantile1e3);
}

// The estimate of `fit`, with warnings of corners that no picture of this size shows and of points
// that fit in their mirror image only.
auto with_view_checks(const ViewCorrespondences& seen, const ImageSize& size, const auto& fit) {
  auto estimate = fit(seen.correspondences);
  if (is_mirrored(seen.ids, seen.correspondences)) {
    add(estimate.findings, code::view_mirrored,
        "the tags are mirrored, as no camera sees them: the picture or its corners were mirrored");
  } else if (estimate.status == Status::no_consensus) {
    std::vector<Correspondence> mirrored = seen.correspondences;
    for (Correspondence& c : mirrored) c.point.x() *= -1;
    if (is_answer(fit(mirrored).status)) say_mirror_image_fits(estimate.findings);
  }
  if (auto warning =
          corners_outside(num_outside(seen.correspondences, size), seen.ids.size(), size))
    estimate.findings.push_back(*std::move(warning));
  return estimate;
}

}  // namespace

PoseEstimate estimate_pose(std::span<const Correspondence> correspondences, const Camera& camera,
                           const PoseOptions& options) {
  PoseEstimate estimate;
  const RobustPose<6> robust = fitted<6>(correspondences, camera.lens, options, estimate);
  if (!robust.fit) return judged(std::move(estimate));
  if (estimate.hypotheses.empty()) {
    add(estimate.findings, code::degenerate,
        "the points do not determine a pose: their information is singular");
  } else if (is_turn_about_line_unknown(*robust.problem, camera.lens, *robust.fit)) {
    estimate.hypotheses.clear();
    add(estimate.findings, code::degenerate,
        "the points are nearly on a line, and the noise hides the turn about it: use a wider "
        "target");
  } else {
    check_convergence(*robust.fit, estimate.findings);
  }
  return judged(std::move(estimate));
}

PoseAndFocalEstimate estimate_pose_and_focal(std::span<const Correspondence> correspondences,
                                             const ImageSize& image_size,
                                             const PoseAndFocalOptions& options) {
  PoseAndFocalEstimate estimate;
  if (const std::string reason = defect(image_size, options); !reason.empty()) {
    add(estimate.findings, code::degenerate, reason);
    return judged(std::move(estimate));
  }
  const double guess = options.prior_focal_px > 0 ? options.prior_focal_px
                                                  : std::max(image_size.width, image_size.height);
  const Lens lens = plain_pinhole(guess, image_size);
  const RobustPose<7> robust =
      fitted<7>(correspondences, lens, options, estimate, &estimate.covariance);
  if (!robust.fit) return judged(std::move(estimate));
  const auto relative_sigma = [&] {
    return estimate.hypotheses.empty() ? std::numeric_limits<double>::infinity()
                                       : std::sqrt(estimate.covariance(6, 6));
  };
  const double of_noise = relative_sigma();
  if (!options.exact_pinhole) add_error_of_pinhole(correspondences, image_size, options, estimate);
  const double relative = relative_sigma();
  Solutions<WeakPerspectivePose, 2> weak;
  if (is_focal_observable(robust, relative, image_centre(image_size), weak)) {
    estimate.focal_px = estimate.hypotheses.front().focal_px;
    estimate.sigma_focal_px = relative * estimate.focal_px;
    check_convergence(*robust.fit, estimate.findings);
    return judged(std::move(estimate));
  }
  estimate.hypotheses.clear();
  estimate.covariance.setZero();
  if (!robust.model_error) estimate.weak_perspective = in_target_frame(*robust.problem, weak);
  add(estimate.findings, code::focal_not_observable,
      refusal(relative, of_noise, robust.model_error));
  if (options.prior_focal_px > 0)
    add_poses_of_prior(correspondences, image_size, options, estimate);
  return judged(std::move(estimate));
}

PoseEstimate estimate_pose(const ViewCorrespondences& seen, const Camera& camera,
                           const PoseOptions& options) {
  return with_view_checks(seen, camera.image_size, [&](const auto& correspondences) {
    return estimate_pose(correspondences, camera, seen.with_these(options));
  });
}

PoseEstimate estimate_pose(const ViewCorrespondences& seen, const UncertainCamera& camera,
                           const PoseOptions& options) {
  camera.check_covariance();
  PoseEstimate estimate = estimate_pose(seen, camera.camera, options);
  if (!camera.is_exact())
    add_lens_error(seen.correspondences, seen.with_these(options), camera, estimate);
  else
    add(estimate.findings, code::lens_without_covariance,
        "the camera has no covariance: its lens is taken as exact");
  return estimate;
}

PoseAndFocalEstimate estimate_pose_and_focal(const ViewCorrespondences& seen,
                                             const ImageSize& image_size,
                                             const PoseAndFocalOptions& options) {
  return with_view_checks(seen, image_size, [&](const auto& correspondences) {
    return estimate_pose_and_focal(correspondences, image_size, seen.with_these(options));
  });
}

}  // namespace tagcal
