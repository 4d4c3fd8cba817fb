#include "tagcal/validate/validate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "tagcal/estimate/pose.hpp"
#include "tagcal/estimate/pose/reprojection.hpp"
#include "tagcal/estimate/view_correspondences.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kJacobianBound = 1e-6;

// OpenCV's projection of points: pixels, and derivatives by rotation vector, translation, fx, fy,
// cx, cy and the distortion, in this order.
struct Theirs {
  std::vector<cv::Point2d> pixels;
  cv::Mat1d jacobian;  // 2n x (10 + distortion)
};

// cv::fisheye orders its derivatives f, c, k, rotation, translation, skew.
cv::Mat1d in_order_of_pinhole(const cv::Mat1d& j) {
  cv::Mat1d result(j.rows, 14);
  j.colRange(8, 14).copyTo(result.colRange(0, 6));
  j.colRange(0, 8).copyTo(result.colRange(6, 14));
  return result;
}

Theirs ask_opencv(const Lens& lens, const Pose& pose, const std::vector<cv::Point3d>& points) {
  const std::span<const double> p = parameters(lens);
  const cv::Matx33d k(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
  cv::Mat1d distortion(1, static_cast<int>(p.size()) - 4);
  for (int i = 0; i < distortion.cols; ++i) distortion(0, i) = p[static_cast<std::size_t>(i) + 4];
  const Vector3d v = log_rotation(pose.rotation());
  const Vector3d& t = pose.translation();
  const cv::Vec3d rotation(v.x(), v.y(), v.z()), translation(t.x(), t.y(), t.z());
  Theirs theirs;
  cv::Mat jacobian;
  if (std::holds_alternative<Fisheye>(lens)) {
    cv::fisheye::projectPoints(points, theirs.pixels, rotation, translation, k, distortion, 0,
                               jacobian);
    theirs.jacobian = in_order_of_pinhole(jacobian);
  } else {
    cv::projectPoints(points, rotation, translation, k, distortion, theirs.pixels, jacobian);
    theirs.jacobian = jacobian;
  }
  return theirs;
}

// Our derivatives in OpenCV's order: every lens parameter free, the rotation by the rotation
// vector. Precondition: all points are in the lens' domain.
Eigen::MatrixXd our_jacobian(const Lens& lens, const Pose& pose, const ViewProblem& view) {
  std::vector<FreeParameter> free;
  for (std::size_t i = 0; i < parameters(lens).size(); ++i)
    free.push_back({parameter_names(lens)[i], {static_cast<int>(i)}});
  const Reprojection ours = reprojection(view, lens, free, pose).value();
  Eigen::MatrixXd all(ours.by_pose.rows(), 6 + ours.by_parameters.cols());
  all << ours.by_pose.leftCols<3>() * left_jacobian(log_rotation(pose.rotation())),
      ours.by_pose.rightCols<3>(), ours.by_parameters;
  return all;
}

// The view's points that both can project: in our domain and, as OpenCV divides by z, in front.
ViewProblem comparable(std::span<const Correspondence> all, const Lens& lens, const Pose& pose,
                       int& outside) {
  ViewProblem some;
  for (const Correspondence& c : all) {
    const Vector3d x = pose * c.point;
    if (in_domain(lens, x) && x.z() > 0)
      some.correspondences.push_back(c);
    else
      ++outside;
  }
  return some;
}

void compare_view(const Camera& camera, const Pose& pose, std::span<const Correspondence> all,
                  Validation& result) {
  const ViewProblem view = comparable(all, camera.lens, pose, result.num_outside_domain);
  if (view.correspondences.empty()) return;
  std::vector<cv::Point3d> points;
  for (const Correspondence& c : view.correspondences)
    points.emplace_back(c.point.x(), c.point.y(), c.point.z());
  const Theirs theirs = ask_opencv(camera.lens, pose, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector2d ours = *project(camera.lens, pose * view.correspondences[i].point);
    const double difference =
        (ours - Vector2d(theirs.pixels[i].x, theirs.pixels[i].y)).cwiseAbs().maxCoeff();
    // std::max would ignore a NaN.
    if (!(difference <= result.max_projection_difference_px))
      result.max_projection_difference_px = difference;
    ++result.num_compared;
  }
  const Eigen::MatrixXd ours = our_jacobian(camera.lens, pose, view);
  for (Eigen::Index column = 0; column < ours.cols(); ++column) {
    const double largest = ours.col(column).cwiseAbs().maxCoeff();
    for (Eigen::Index row = 0; row < ours.rows(); ++row) {
      const double difference =
          std::abs(ours(row, column) -
                   theirs.jacobian(static_cast<int>(row), static_cast<int>(column))) /
          std::max(largest, 1e-300);
      if (!(difference <= result.max_jacobian_difference))
        result.max_jacobian_difference = difference;
    }
  }
}

void compare_with_truth(const Camera& camera, const std::vector<double>& sigmas, const Truth& truth,
                        Validation& result) {
  if (truth.camera.lens.index() != camera.lens.index()) {
    result.warnings.emplace_back("the truth is another kind of lens: parameters are not compared");
    return;
  }
  const auto estimate = parameters(camera.lens), exact = parameters(truth.camera.lens);
  for (std::size_t i = 0; i < exact.size(); ++i) {
    ParameterError error{
        std::string(parameter_names(camera.lens)[i]), estimate[i], exact[i], {}, {}};
    if (i < sigmas.size()) error.sigma = sigmas[i];
    const double difference = estimate[i] - exact[i];
    if (error.sigma > 0) error.in_sigmas = difference / *error.sigma;
    if (error.sigma == 0 && difference != 0)
      result.warnings.push_back(fmt::format("{} is held at {:g}, the truth is {:g}", error.name,
                                            error.estimate, error.truth));
    result.parameters.push_back(error);
    if (error.in_sigmas)
      result.num_beyond_truth =
          result.num_beyond_truth.value_or(0) + (std::abs(*error.in_sigmas) <= kTruthBound ? 0 : 1);
  }
}

}  // namespace

Validation validate(const Camera& camera, const std::vector<double>& sigmas, const Dataset& dataset,
                    const std::optional<double>& camera_error_px) {
  Validation result;
  const LensKind& kind = kind_of(camera.lens);
  const bool is_fisheye = &kind == &kind_of<Fisheye>();
  const bool has_witness = is_fisheye || &kind == &kind_of<Perspective>();
  result.bound_px = is_fisheye ? 1e-8 : 1e-9;
  const auto points = points_in_world(dataset.boards);
  double sum = 0;
  std::size_t count = 0;
  for (const View& view : dataset.views) {
    const ViewCorrespondences seen = view_correspondences(view, points, camera_error_px);
    const PoseEstimate pose = estimate_pose(seen, camera);
    if (!is_answer(pose.status)) {
      ++result.num_without_pose;
      result.warnings.push_back(
          fmt::format("{}: no pose ({})", view.image, status_name(pose.status)));
      continue;
    }
    ++result.num_views;
    for (const Vector2d& r :
         residuals_px(seen.correspondences, camera.lens, pose.camera_from_target()))
      if (r.allFinite()) sum += r.squaredNorm(), ++count;
    if (has_witness) compare_view(camera, pose.camera_from_target(), seen.correspondences, result);
  }
  result.rms_px = count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
  if (dataset.truth) compare_with_truth(camera, sigmas, *dataset.truth, result);
  if (!has_witness)
    result.warnings.push_back(
        fmt::format("OpenCV has no {} lens: nothing to compare with", kind.name));
  result.opencv_agrees = result.num_compared > 0 &&
                         result.max_projection_difference_px <= result.bound_px &&
                         result.max_jacobian_difference <= kJacobianBound;
  return result;
}

std::vector<ParameterError> validate_place(const KnownRig& rig, const RigTruth& truth,
                                           std::size_t camera, std::size_t reference) {
  constexpr const char* kNames[] = {"rotation x",    "rotation y",    "rotation z",
                                    "translation x", "translation y", "translation z"};
  const auto place = [&](const Pose& a, const Pose& b) { return a * b.inverse(); };
  const Pose estimate =
      place(rig.cameras[camera].camera_from_rig, rig.cameras[reference].camera_from_rig);
  const Pose exact = place(truth.camera_from_rig[camera], truth.camera_from_rig[reference]);
  Vector6d values, exact_values;
  values << log_rotation(estimate.rotation()), estimate.translation();
  exact_values << log_rotation(exact.rotation()), exact.translation();
  const Vector6d difference = minus(estimate, exact);
  std::vector<ParameterError> errors;
  for (int i = 0; i < 6; ++i) {
    ParameterError error{kNames[i], values[i], exact_values[i], {}, {}};
    const Eigen::Index at = 6 * static_cast<Eigen::Index>(camera) + i;
    if (rig.covariance.size() > 0) error.sigma = std::sqrt(std::max(0.0, rig.covariance(at, at)));
    if (error.sigma > 0) error.in_sigmas = difference[i] / *error.sigma;
    errors.push_back(error);
  }
  return errors;
}

}  // namespace tagcal
