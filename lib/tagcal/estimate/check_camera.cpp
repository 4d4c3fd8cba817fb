#include "tagcal/estimate/check_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/error.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/bundle/repeated_poses.hpp"
#include "tagcal/estimate/camera_check/candidates.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/check_policy.hpp"
#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

void report_limits(const FreeFit& fit, const KnownRig& known, CameraCheck& check) {
  std::size_t most_poses = 0;
  for (std::size_t c = 0; c < fit.cameras.size(); ++c) {
    const Bundle& bundle = fit.state.cameras[c];
    most_poses = std::max(most_poses, num_poses(pose_numbers(bundle)));
    const std::string prefix = fit.cameras.size() > 1 ? fit.cameras[c].name + ": " : "";
    if (!known.cameras[c].camera.model || known.covariance.size() == 0)
      add(check.findings, code::camera_exact,
          prefix +
              "the camera's file has no covariance: it is taken as exact, so that errors of "
              "its calibration count as changes");
    if (const auto gaps = seen_region(bundle).gaps(); gaps && num_corners(bundle) > 0)
      add(check.findings, code::extrapolated, prefix + *gaps + ": a change there is not tested");
  }
  if (most_poses < policy::kFewestCheckedPoses)
    add(check.findings, code::few_views,
        "one pose of the board does not tell a change of the camera from an error of the board: "
        "take two pictures or more, with the board at different places and tilts");
}

bool has(const CameraCheck& check, const FindingCode& code) {
  return std::ranges::any_of(check.findings, [&](const Finding& f) { return f.code == code.name; });
}

// A change of all lengths that hides one that matters: a board on paper gives them to 0.1 or 0.2 %.
void report_scale(double limit_px, CameraCheck& check) {
  for (const DetectableChange& change : check.detectable) {
    if (change.kind != ChangeKind::place || change.max_px <= limit_px ||
        change.without_scale_px > limit_px)
      continue;
    add(check.findings, code::scale_untested,
        fmt::format(
            "the lengths of the rig are known as those of the board are, by `print` in its target "
            "file: {} could be {:.2g} mm from its place if all lengths changed alike, as with "
            "another print; any other move shows from {:.2g} px. Measure the board, state `print`, "
            "and calibrate the rig again",
            check.cameras[change.camera].name, change.size, change.without_scale_px));
  }
}

void judge_check(double limit_px, CameraCheck& check) {
  if (has(check, code::few_views)) return;
  check.verdict = change_verdict(check.in_sigmas, check.smallest_px, limit_px);
}

void require_options(const RigDataset& dataset, const KnownRig& known,
                     const CheckOptions& options) {
  if (!(options.limit_px > 0))
    throw Error(fmt::format("limit_px: must be > 0, got {}", options.limit_px));
  if (known.cameras.empty() || dataset.cameras.size() != known.cameras.size())
    throw Error(fmt::format("rig: has {} cameras, got the pictures of {}", known.cameras.size(),
                            dataset.cameras.size()));
  known.check_covariance();
  if (known.covariance.size() > 0 && known.cameras.size() > 1 && !known.reference())
    throw Error("rig: its frame must be that of one of its cameras");
  for (std::size_t c = 0; c < known.cameras.size(); ++c) {
    const Camera& camera = known.cameras[c].camera.camera;
    if (!kind_of(camera.lens).is_central)
      throw Error(known.cameras[c].name + ": a parallel lens cannot be checked");
    const ImageSize &size = camera.image_size, &seen = dataset.cameras[c].data.image_size;
    if (!(size == seen))
      throw Error(fmt::format("{}: image size must be {}x{}, got {}x{}", known.cameras[c].name,
                              size.width, size.height, seen.width, seen.height));
  }
}

CameraCheck check_once(const RigDataset& dataset, const KnownRig& known,
                       const CheckOptions& options) {
  CameraCheck check;
  check.in_sigmas = -kInfinite;
  check.smallest_px = kInfinite;
  check.false_alarm = policy::kFalseAlarm;
  check.power = policy::kDetectionPower;
  const auto fit = fit_freely(dataset, known, options, check.findings);
  if (!fit) {
    add(check.findings, code::target_unseen, "no picture determines a pose of the target");
    return check;
  }
  check.cameras = fit->cameras;
  report_limits(*fit, known, check);
  for (std::size_t c = 0; c < fit->strain.size(); ++c)
    if (fit->strain[c] > policy::kStrainedCheck)
      add(check.findings, code::pair_contradicts,
          fmt::format("the rig moves the corners of {} by {:.1f} times what its lens leaves: its "
                      "pictures were taken at other times than those of the others",
                      fit->cameras[c].name, fit->strain[c]));
  if (has(check, code::pair_contradicts)) return check;
  const auto information = rig_information(fit->state, RigLayout(fit->state, fit->connected));
  if (!information) {
    add(check.findings, code::degenerate, "the corners of a picture do not determine its pose");
    return check;
  }
  const ChangeTest test(*fit, known, *information);
  check.in_sigmas = test.score();
  const std::vector<PossibleChange> candidates = candidates_of(*fit, information->prior.rows());
  check.smallest_px = 0;
  for (const PossibleChange& candidate : candidates) {
    check.detectable.push_back(detectable(candidate, test, *fit));
    if (candidate.kind != ChangeKind::lens)
      check.smallest_px = std::max(check.smallest_px, check.detectable.back().max_px);
  }
  report_scale(options.limit_px, check);
  judge_check(options.limit_px, check);
  if (check.in_sigmas > policy::kCheckQuantile)
    check.change = leanest_change(candidates, test, *fit);
  return check;
}

// Names two cameras with which the pictures agree if they exchange theirs.
void report_exchange(const RigDataset& dataset, const KnownRig& known, const CheckOptions& options,
                     CameraCheck& check) {
  for (std::size_t b = 1; b < dataset.cameras.size(); ++b)
    for (std::size_t a = 0; a < b; ++a) {
      if (dataset.cameras[a].data.image_size != dataset.cameras[b].data.image_size) continue;
      RigDataset exchanged = dataset;
      std::swap(exchanged.cameras[a].data.views, exchanged.cameras[b].data.views);
      std::swap(exchanged.cameras[a].times_s, exchanged.cameras[b].times_s);
      for (Instant& instant : exchanged.instants) std::swap(instant.view[a], instant.view[b]);
      const double in_sigmas = check_once(exchanged, known, options).in_sigmas;
      if (!std::isfinite(in_sigmas) || in_sigmas > policy::kCheckQuantile) continue;
      add(check.findings, code::sizes_swapped,
          fmt::format("the pictures agree with the rig if {} and {} exchange theirs: exchange "
                      "their folders",
                      known.cameras[a].name, known.cameras[b].name));
      return;
    }
}

}  // namespace

std::string_view kind_name(ChangeKind kind) {
  static constexpr std::string_view kNames[] = {"focal length", "principal point",
                                                "focal length and principal point",
                                                "place in the rig", "lens"};
  return kNames[static_cast<std::size_t>(kind)];
}

CameraCheck check_rig(const RigDataset& dataset, const KnownRig& known,
                      const CheckOptions& options) {
  require_options(dataset, known, options);
  CameraCheck check = check_once(dataset, known, options);
  if (check.in_sigmas > policy::kCheckQuantile && !check.change)
    report_exchange(dataset, known, options, check);
  return check;
}

CameraCheck check_camera(const Dataset& dataset, const UncertainCamera& known,
                         const CheckOptions& options) {
  KnownRig rig;
  rig.cameras.push_back({"camera", known, Pose(), std::nullopt});
  const Index k = known.num_free();
  if (known.covariance.size() > 0) {
    rig.covariance = MatrixXd::Zero(6 + k, 6 + k);
    rig.covariance.bottomRightCorner(k, k) = known.covariance;
  }
  return check_rig({{{"camera", dataset, {}}}, {}, std::nullopt}, rig, options);
}

std::optional<Finding> contradiction_of_camera(const Dataset& pictures,
                                               const UncertainCamera& known,
                                               std::size_t num_threads) {
  std::ptrdiff_t num_corners = 0;
  for (const View& view : pictures.views) num_corners += std::ssize(view.observations);
  if (num_corners < policy::kFewestCheckedCorners) return std::nullopt;
  const CameraCheck check = check_camera(pictures, known, {.num_threads = num_threads});
  if (!(check.in_sigmas > policy::kSignificant)) return std::nullopt;
  std::string what = "no single change explains it";
  if (check.change)
    what = fmt::format("a change of the {} by {:.2g} px at most explains it",
                       kind_name(check.change->kind), check.change->max_px);
  return finding(
      code::camera_changed,
      fmt::format("the residuals contradict the camera's file by {:.1f} sd ({}): {}",
                  check.in_sigmas, what,
                  pictures.views.size() == 1
                      ? "check it with more pictures"
                      : "the camera is no longer as it was calibrated, or the board is not"));
}

std::optional<Finding> contradiction_of_camera(const View& view,
                                               const std::vector<PlacedBoard>& boards,
                                               const UncertainCamera& known) {
  return contradiction_of_camera({known.camera.image_size, boards, {view}, {}}, known);
}

}  // namespace tagcal
