#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/bundle/held_lens.hpp"
#include "tagcal/estimate/bundle/linked_poses.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/estimate/pose/reprojection.hpp"
#include "tagcal/solvers/numeric/minimise.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal {
using namespace internal;
namespace {

// A camera that has a pose of its own: its inliers, with a noise of 1.
struct SeeingCamera {
  std::size_t index = 0;
  const KnownRig::Member* camera = nullptr;
  const PoseEstimate* own = nullptr;
  ViewProblem view;
};

// The step of a camera's pose by that of the rig (`retract`).
Matrix6 by_rig(const KnownRig::Member& camera) {
  return step_by(camera.camera_from_rig.rotation_matrix(), Eigen::Vector3d::Zero());
}

// The squared residuals of all cameras by the pose of the rig (solvers/numeric/minimise.hpp).
struct RigPoseProblem {
  using State = Pose;
  struct Equations {
    double cost = 0;
    Matrix6 information = Matrix6::Zero();
    Vector6d gradient = Vector6d::Zero();

    std::optional<DampedStep<Vector6d>> step(double damping) const {
      Eigen::Matrix<double, 6, 6> damped = information;
      damped.diagonal() *= 1 + damping;
      const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> ldlt(damped);
      if (ldlt.info() != Eigen::Success || !ldlt.isPositive()) return std::nullopt;
      const Vector6d step = -ldlt.solve(gradient);
      return DampedStep<Vector6d>{step, -step.dot(gradient)};
    }
  };

  std::span<const SeeingCamera> cameras;

  // The products [J | r]'[J | r] of a camera's rows by its own pose.
  static std::optional<Eigen::MatrixXd> products(const SeeingCamera& seeing,
                                                 const Pose& camera_pose) {
    const auto upper = products_of(seeing.view, {}, seeing.camera->camera.camera.lens, camera_pose);
    if (!upper) return std::nullopt;
    return Eigen::MatrixXd(upper->selfadjointView<Eigen::Upper>());
  }

  std::optional<Equations> at(const Pose& rig_from_target) const {
    Equations sum;
    for (const SeeingCamera& seeing : cameras) {
      const auto gram = products(seeing, seeing.camera->camera_from_rig * rig_from_target);
      if (!gram) return std::nullopt;
      const Matrix6 by = by_rig(*seeing.camera);
      sum.information += by.transpose() * gram->topLeftCorner<6, 6>() * by;
      sum.gradient += by.transpose() * gram->block<6, 1>(0, 6);
      sum.cost += (*gram)(6, 6);
    }
    return sum;
  }

  Pose stepped(const Pose& pose, const Vector6d& step) const { return retract(pose, step); }
};

// The step of a camera's pose by that of its place.
Matrix6 by_place(const SeeingCamera& seeing, const Pose& rig_from_target) {
  return step_by(Eigen::Matrix3d::Identity(),
                 seeing.camera->camera_from_rig.rotation_matrix() * rig_from_target.translation());
}

// The step of the rig's pose, as one camera alone sees it, by places and lenses (6 x all of them):
// the camera's own pose answers to its lens, less the step by its place. No columns if they are
// exact; no value if the view does not determine the pose.
std::optional<Eigen::MatrixXd> response_of_own(const SeeingCamera& seeing, const KnownRig& rig,
                                               const Pose& rig_from_target, const Pose& own_pose) {
  if (rig.covariance.size() == 0) return Eigen::MatrixXd(6, 0);
  Eigen::MatrixXd response = Eigen::MatrixXd::Zero(6, rig.covariance.cols());
  response.middleCols<6>(6 * static_cast<Eigen::Index>(seeing.index)) =
      -by_place(seeing, rig_from_target);
  const UncertainCamera& camera = seeing.camera->camera;
  if (camera.num_free() == 0) return response;
  const auto by_lens = lens_response(seeing.view, camera, own_pose, false);
  if (!by_lens) return std::nullopt;
  response.middleCols(rig.first_of_lens(seeing.index), camera.num_free()) = by_lens->by_lens;
  return response;
}

// The rig's pose with its covariance by the noise of the corners and its response to places and
// lenses: the cameras' own responses, each weighed by its information.
std::optional<SeenPose> seen_by_rig(std::span<const SeeingCamera> cameras, const KnownRig& rig,
                                    const Pose& pose, const Matrix6& information) {
  const auto inverse = exact_inverse(information);
  if (!inverse) return std::nullopt;
  SeenPose seen{pose, *inverse};
  if (rig.covariance.size() == 0) return seen;
  seen.response = Eigen::MatrixXd::Zero(6, rig.covariance.cols());
  for (const SeeingCamera& seeing : cameras) {
    const Pose camera_pose = seeing.camera->camera_from_rig * pose;
    const auto own = response_of_own(seeing, rig, pose, camera_pose);
    const auto gram = RigPoseProblem::products(seeing, camera_pose);
    if (!own || !gram) return std::nullopt;
    seen.response +=
        *inverse * by_rig(*seeing.camera).transpose() * gram->topLeftCorner<6, 6>() * *own;
  }
  return seen;
}

// Zero for exact places and lenses.
Matrix6 covariance_of(const Eigen::MatrixXd& response, const KnownRig& rig) {
  if (response.size() == 0) return Matrix6::Zero();
  return response * rig.covariance * response.transpose();
}

// The chi-square, of six degrees of freedom, by which a camera's own poses contradict that of the
// rig: of the best of them. Both answer to places and lenses, and their difference counts. Corners
// of less noise than policy::kLeastSigmaPx count with that: below it what is not modelled decides.
double contradiction_of(const SeeingCamera& seeing, const KnownRig& rig, const SeenPose& joint) {
  const Pose& pose = joint.camera_from_target;
  const Pose predicted = seeing.camera->camera_from_rig * pose;
  const double sigma = seeing.own->sigma_px;
  const double raised = sigma > 0 ? std::max(1.0, policy::kLeastSigmaPx / sigma) : 1;
  double least = std::numeric_limits<double>::infinity();
  for (const PoseHypothesis& own : seeing.own->hypotheses) {
    auto response = response_of_own(seeing, rig, pose, own.camera_from_target);
    if (!response) continue;
    if (response->size() > 0) *response -= by_rig(*seeing.camera) * joint.response;
    const Eigen::Matrix<double, 6, 6> covariance =
        raised * raised * own.covariance + covariance_of(*response, rig);
    const Vector6d step = minus(predicted, own.camera_from_target);
    least = std::min(least, step.dot(covariance.ldlt().solve(step)));
  }
  return least;
}

struct JointMinimum {
  Pose rig_from_target;
  double cost = 0;
  Matrix6 information = Matrix6::Zero();
};

struct JointPose {
  SeenPose seen;
  double cost = 0;
};

// The minima from all poses of single cameras, the best first, each once.
std::vector<JointMinimum> joint_minima(std::span<const SeeingCamera> cameras) {
  constexpr double kSamePose = 1e-3;  // numeric: standard deviations between runs to one minimum
  const RigPoseProblem problem{cameras};
  std::vector<JointMinimum> minima;
  for (const SeeingCamera& seeing : cameras)
    for (const PoseHypothesis& own : seeing.own->hypotheses) {
      const Pose start = seeing.camera->camera_from_rig.inverse() * own.camera_from_target;
      const auto minimum = minimise(problem, start);
      if (!minimum) continue;
      const bool is_known = std::ranges::any_of(minima, [&](const JointMinimum& other) {
        const Vector6d step = minus(minimum->state, other.rig_from_target);
        return step.dot(other.information * step) < kSamePose * kSamePose;
      });
      if (!is_known) minima.push_back({minimum->state, minimum->at.cost, minimum->at.information});
    }
  std::ranges::sort(minima, {}, &JointMinimum::cost);
  return minima;
}

// Those of them that the residuals do not exclude.
std::vector<JointPose> joint_poses(std::span<const SeeingCamera> cameras, const KnownRig& rig) {
  const std::vector<JointMinimum> minima = joint_minima(cameras);
  std::vector<JointPose> poses;
  for (const JointMinimum& minimum : minima) {
    if (minimum.cost > minima.front().cost + policy::kAmbiguousCost) break;
    if (auto seen = seen_by_rig(cameras, rig, minimum.rig_from_target, minimum.information))
      poses.push_back({*std::move(seen), minimum.cost});
  }
  return poses;
}

double rms_px_of(std::span<const SeeingCamera> cameras, const Pose& rig_from_target) {
  double sum = 0;
  std::size_t count = 0;
  for (const SeeingCamera& seeing : cameras) {
    const auto& corners = seeing.view.correspondences;
    for (const auto& r : residuals_px(corners, seeing.camera->camera.camera.lens,
                                      seeing.camera->camera_from_rig * rig_from_target))
      sum += r.squaredNorm();
    count += corners.size();
  }
  return std::sqrt(sum / static_cast<double>(count));
}

// Adds a pose with both parts of its covariance.
void add_hypothesis(const SeenPose& seen, const KnownRig& rig, double rms_px, double probability,
                    RigPoseEstimate& estimate) {
  estimate.rig.hypotheses.push_back({seen.camera_from_target,
                                     seen.covariance + covariance_of(seen.response, rig),
                                     seen.covariance, rms_px, probability});
  estimate.parts.push_back(seen);
}

// Adds the poses with their probabilities.
void add_hypotheses(std::span<const SeeingCamera> cameras, const KnownRig& rig,
                    const std::vector<JointPose>& poses, RigPoseEstimate& estimate) {
  double sum = 0;
  for (const auto& [seen, cost] : poses) {
    const double likelihood = std::exp((poses.front().cost - cost) / 2);
    sum += likelihood;
    add_hypothesis(seen, rig, rms_px_of(cameras, seen.camera_from_target), likelihood, estimate);
  }
  for (PoseHypothesis& hypothesis : estimate.rig.hypotheses) hypothesis.probability /= sum;
}

// The camera that contradicts the rig most, if one does.
std::optional<std::size_t> contradiction(std::span<const SeeingCamera> cameras, const KnownRig& rig,
                                         const SeenPose& joint) {
  std::optional<std::size_t> worst;
  double most = chi_square_quantile(6, policy::kOutlierSigmas);
  for (std::size_t i = 0; i < cameras.size(); ++i)
    if (const double square = contradiction_of(cameras[i], rig, joint); square > most) {
      most = square;
      worst = i;
    }
  return worst;
}

// Takes the cameras out that contradict the others, in turn, and estimates the pose by the rest.
std::vector<JointPose> solve_without_contradictions(std::vector<SeeingCamera>& cameras,
                                                    const KnownRig& rig,
                                                    std::vector<Finding>& findings) {
  for (;;) {
    std::vector<JointPose> poses = joint_poses(cameras, rig);
    if (poses.empty()) return poses;
    const auto wrong = contradiction(cameras, rig, poses.front().seen);
    if (!wrong) return poses;
    const std::string& name = cameras[*wrong].camera->name;
    if (cameras.size() == 2) {
      add(findings, code::pair_contradicts,
          fmt::format("{} and {} contradict one another: the pictures are not of one instant, or "
                      "a camera of the rig moved since it was calibrated",
                      cameras[0].camera->name, cameras[1].camera->name));
      return {};
    }
    add(findings, code::camera_contradicts,
        fmt::format("{} contradicts the other cameras and is not used: its picture is not of the "
                    "same instant, or it moved since the rig was calibrated",
                    name));
    cameras.erase(cameras.begin() + static_cast<std::ptrdiff_t>(*wrong));
  }
}

// Adds the own poses of the only camera that sees the target, in the frame of the rig.
void add_hypotheses_of_one(const SeeingCamera& seeing, const KnownRig& rig,
                           RigPoseEstimate& estimate) {
  const Pose rig_from_camera = seeing.camera->camera_from_rig.inverse();
  const Matrix6 by_own = by_rig(*seeing.camera).transpose();
  for (const PoseHypothesis& own : seeing.own->hypotheses) {
    SeenPose seen{rig_from_camera * own.camera_from_target,
                  by_own * own.covariance * by_own.transpose()};
    const auto response =
        response_of_own(seeing, rig, seen.camera_from_target, own.camera_from_target);
    if (!response) continue;
    seen.response = by_own * *response;
    add_hypothesis(seen, rig, own.rms_px, own.probability, estimate);
  }
}

// The warnings of the cameras that take part, with their names.
void add_warnings_of(std::span<const SeeingCamera> cameras, std::vector<Finding>& findings) {
  for (const SeeingCamera& seeing : cameras)
    for (const Finding& finding : seeing.own->findings)
      if (finding.severity == Severity::warning)
        findings.push_back(
            {finding.code, finding.severity, seeing.camera->name + ": " + finding.sentence});
}

}  // namespace

KnownRig known_rig(const RigCalibration& rig) {
  KnownRig known;
  for (const RigCameraEstimate& camera : rig.cameras)
    known.cameras.push_back({camera.name, camera.camera, camera.camera_from_rig, camera.error_px});
  known.set_joint_covariance(rig.covariance);
  return known;
}

RigPoseEstimate estimate_rig_pose(std::span<const ViewCorrespondences> seen, const KnownRig& rig,
                                  const PoseOptions& options) {
  const std::size_t n = rig.cameras.size();
  if (seen.size() != n)
    throw Error(fmt::format("rig: has {} cameras, got the corners of {}", n, seen.size()));
  rig.check_covariance();
  RigPoseEstimate estimate;
  estimate.takes_part.assign(n, 0);
  std::vector<SeeingCamera> cameras;
  for (std::size_t c = 0; c < n; ++c)
    estimate.of_cameras.push_back(estimate_pose(seen[c], rig.cameras[c].camera.camera, options));
  for (std::size_t c = 0; c < n; ++c)
    if (const PoseEstimate& own = estimate.of_cameras[c]; is_answer(own.status))
      cameras.push_back(
          {c, &rig.cameras[c], &own,
           inlier_view(seen[c].correspondences, seen[c].with_these(options).covariance_px2,
                       own.outliers, std::max(own.sigma_px, kLeastNoisePx))});
  PoseEstimate& joint = estimate.rig;
  if (cameras.empty())
    add(joint.findings, code::target_unseen, "no camera alone determines a pose of the target");
  if (cameras.size() == 1) {
    add_hypotheses_of_one(cameras.front(), rig, estimate);
  } else {
    const auto poses = solve_without_contradictions(cameras, rig, joint.findings);
    add_hypotheses(cameras, rig, poses, estimate);
  }
  add_warnings_of(cameras, joint.findings);
  if (joint.hypotheses.empty() && is_answer(judge(joint.findings)))
    add(joint.findings, code::not_converged, "no pose of the rig lies before all cameras");
  joint.status = judge(joint.findings);
  if (joint.status == Status::ok && joint.hypotheses.size() > 1) joint.status = Status::ambiguous;
  for (const SeeingCamera& seeing : cameras) estimate.takes_part[seeing.index] = 1;
  return estimate;
}

}  // namespace tagcal
