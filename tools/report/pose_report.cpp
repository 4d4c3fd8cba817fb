#include "report/pose_report.hpp"

#include "report/findings.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "tagcal/estimate/pose.hpp"
#include "tagcal/geometry/viewpoint.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

constexpr std::size_t kOutliersShown = 12;

double degrees(double rad) { return rad * 180 / std::numbers::pi; }

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

// Returns the quaternion with w >= 0, so that equal poses look equal.
Eigen::Quaterniond shown_rotation(const Pose& pose) {
  Eigen::Quaterniond q = pose.rotation();
  if (q.w() < 0) q.coeffs() *= -1;
  return q;
}

Json rotation_json(const Pose& pose) {
  const Eigen::Quaterniond q = shown_rotation(pose);
  return {q.w(), q.x(), q.y(), q.z()};
}

Json pose_json(const Pose& pose) {
  const Vector3d& t = pose.translation();
  return {{"rotation", rotation_json(pose)}, {"translation_m", {t.x(), t.y(), t.z()}}};
}

Json covariance_json(const Matrix6& covariance) {
  Json rows = Json::array();
  for (int r = 0; r < 6; ++r) {
    Json row = Json::array();
    for (int c = 0; c < 6; ++c) row.push_back(covariance(r, c));
    rows.push_back(row);
  }
  return rows;
}

Json vector_json(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Vector6d sigmas_of(const Matrix6& covariance) {
  const Vector6d variance = covariance.diagonal();
  return variance.unaryExpr([](double v) { return std::sqrt(v < 0 ? 0 : v); });
}

// NaN, of an angle that is not defined, becomes null.
Json camera_json(const PoseHypothesis& hypothesis) {
  const CameraInTarget camera = camera_in_target(hypothesis);
  const Vector6d sigma = sigmas_of(camera.covariance);
  return {{"position_m", vector_json(camera.position_m)},
          {"azimuth_deg", degrees(camera.azimuth_rad)},
          {"elevation_deg", degrees(camera.elevation_rad)},
          {"roll_deg", degrees(camera.roll_rad)},
          {"sigma_position_m", vector_json(sigma.head<3>())},
          {"sigma_azimuth_deg", degrees(sigma[3])},
          {"sigma_elevation_deg", degrees(sigma[4])},
          {"sigma_roll_deg", degrees(sigma[5])}};
}

Json alternative_json(const std::vector<PoseHypothesis>& hypotheses) {
  if (hypotheses.size() < 2) return nullptr;
  const PoseHypothesis& other = hypotheses[1];
  return {{"camera_from_board", pose_json(other.camera_from_target)},
          {"covariance", covariance_json(other.covariance)},
          {"camera_in_target", camera_json(other)},
          {"rms_px", other.rms_px},
          {"probability", other.probability}};
}

Json outliers_json(const PoseReport& view) {
  Json list = Json::array();
  for (const std::size_t i : view.outliers)
    list.push_back({{"tag_id", view.corners[i].tag_id}, {"corner", view.corners[i].corner}});
  return list;
}

// The translation has two coordinates: weak perspective does not determine the third one.
Json weak_perspective_json(const std::vector<WeakPerspectivePose>& poses) {
  if (poses.empty()) return nullptr;
  Json list = Json::array();
  for (const WeakPerspectivePose& weak : poses) {
    const Vector3d& t = weak.camera_from_target.translation();
    list.push_back({{"rotation", rotation_json(weak.camera_from_target)},
                    {"translation_m", {t.x(), t.y()}},
                    {"scale_px_per_m", weak.scale_px_per_m},
                    {"rms_px", weak.rms_px}});
  }
  return list;
}

Json view_json(const PoseReport& view) {
  const PoseHypothesis* best = view.hypotheses.empty() ? nullptr : &view.hypotheses.front();
  const std::size_t num_inliers = view.corners.size() - view.outliers.size();
  return {{"image", view.image},
          {"status", status_name(view.status)},
          {"camera_from_board", best ? pose_json(best->camera_from_target) : Json()},
          {"covariance", best ? covariance_json(best->covariance) : Json()},
          {"camera_in_target", best ? camera_json(*best) : Json()},
          {"focal_px", or_null(view.focal_px)},
          {"sigma_focal_px", or_null(view.sigma_focal_px)},
          {"prior_focal_px", or_null(view.prior_focal_px)},
          {"rms_px", best ? Json(best->rms_px) : Json()},
          {"num_inliers", best ? Json(num_inliers) : Json()},
          {"num_corners", view.corners.size()},
          {"outliers", outliers_json(view)},
          {"probability", best ? Json(best->probability) : Json()},
          {"alternative", alternative_json(view.hypotheses)},
          {"weak_perspective", weak_perspective_json(view.weak_perspective)},
          {"sigma_px", or_null(view.sigma_px)},
          {"findings", findings_json(view.findings)},
          {"warnings", sentences(view.findings)}};
}

std::string line(std::string_view name, const std::string& value) {
  return fmt::format("  {:<13}{}\n", name, value);
}

std::string rotation_lines(const Pose& pose) {
  const Eigen::Quaterniond q = shown_rotation(pose);
  const RollPitchYaw angles = roll_pitch_yaw(q);
  return line("rotation", fmt::format("{:9.6f} {:9.6f} {:9.6f} {:9.6f}  w, x, y, z", q.w(), q.x(),
                                      q.y(), q.z())) +
         line("",
              fmt::format("{:9.4f} {:9.4f} {:9.4f} deg  roll, pitch, yaw", degrees(angles.roll_rad),
                          degrees(angles.pitch_rad), degrees(angles.yaw_rad)));
}

// The camera's place in the target's frame.
std::string camera_lines(const PoseHypothesis& hypothesis) {
  const CameraInTarget camera = camera_in_target(hypothesis);
  const Vector6d sigma = sigmas_of(camera.covariance);
  const Vector3d& at = camera.position_m;
  return line("camera at", fmt::format("{:9.6f} {:9.6f} {:9.6f} m  x, y, z in the target's frame",
                                       at.x(), at.y(), at.z())) +
         line("  sigma", fmt::format("{:9.6f} {:9.6f} {:9.6f} m", sigma[0], sigma[1], sigma[2])) +
         line("looks to", fmt::format("{:9.4f} {:9.4f} {:9.4f} deg  azimuth, elevation, roll",
                                      degrees(camera.azimuth_rad), degrees(camera.elevation_rad),
                                      degrees(camera.roll_rad))) +
         line("  sigma", fmt::format("{:9.4f} {:9.4f} {:9.4f} deg", degrees(sigma[3]),
                                     degrees(sigma[4]), degrees(sigma[5])));
}

// Each line of standard deviations is below the line of its numbers.
std::string hypothesis_lines(const PoseHypothesis& hypothesis) {
  const Pose& pose = hypothesis.camera_from_target;
  const Vector6d sigma = sigmas_of(hypothesis.covariance);
  const Vector3d& t = pose.translation();
  return rotation_lines(pose) +
         line("  sigma", fmt::format("{:9.4f} {:9.4f} {:9.4f} deg  about the camera's x, y, z",
                                     degrees(sigma[0]), degrees(sigma[1]), degrees(sigma[2]))) +
         line("translation",
              fmt::format("{:9.6f} {:9.6f} {:9.6f} m  x, y, z", t.x(), t.y(), t.z())) +
         line("  sigma", fmt::format("{:9.6f} {:9.6f} {:9.6f} m", sigma[3], sigma[4], sigma[5])) +
         camera_lines(hypothesis);
}

std::string poses_text(const PoseReport& view) {
  if (view.hypotheses.size() < 2) return hypothesis_lines(view.hypotheses.front());
  std::string text;
  for (std::size_t i = 0; i < view.hypotheses.size(); ++i) {
    const PoseHypothesis& h = view.hypotheses[i];
    text += fmt::format("  {} with probability {:.4f}, rms {:.4f} px\n",
                        i == 0 ? "likelier pose" : "other pose", h.probability, h.rms_px);
    text += hypothesis_lines(h);
  }
  return text;
}

std::string focal_text(const PoseReport& view) {
  if (view.focal_px)
    return line("focal length", fmt::format("{:.4f} +- {:.4f} px", *view.focal_px,
                                            view.sigma_focal_px.value_or(std::nan(""))));
  if (view.prior_focal_px)
    return line("focal length", fmt::format("not observable; the pose is for {:g} px, as stated",
                                            *view.prior_focal_px));
  return view.status == Status::focal_not_observable ? line("focal length", "not observable") : "";
}

std::string outlier_text(const PoseReport& view) {
  if (view.outliers.empty()) return "";
  std::string names;
  for (std::size_t i = 0; i < std::min(view.outliers.size(), kOutliersShown); ++i) {
    const CornerId& id = view.corners[view.outliers[i]];
    names += fmt::format("{}{}:{}", names.empty() ? "" : " ", id.tag_id, id.corner);
  }
  if (view.outliers.size() > kOutliersShown)
    names += fmt::format(" and {} more", view.outliers.size() - kOutliersShown);
  return line("outliers", names + "  tag:corner");
}

std::string weak_perspective_text(const std::vector<WeakPerspectivePose>& poses) {
  std::string text;
  for (const WeakPerspectivePose& weak : poses) {
    const Vector3d& t = weak.camera_from_target.translation();
    text += fmt::format("  under weak perspective, rms {:.4f} px\n", weak.rms_px);
    text += rotation_lines(weak.camera_from_target);
    text += line("translation", fmt::format("{:9.6f} {:9.6f} m  x, y", t.x(), t.y()));
    text += line("scale", fmt::format("{:.4f} px/m", weak.scale_px_per_m));
  }
  return text;
}

std::string view_text(const PoseReport& view) {
  std::string text = fmt::format("{}: {}\n", view.image, status_name(view.status));
  text += focal_text(view);
  if (!view.hypotheses.empty()) {
    text += poses_text(view);
    text +=
        line("rms", fmt::format("{:.4f} px over {} of {} corners", view.hypotheses[0].rms_px,
                                view.corners.size() - view.outliers.size(), view.corners.size()));
    text += line("noise", view.sigma_px ? fmt::format("{:.4f} px per coordinate", *view.sigma_px)
                                        : "each corner's own covariance");
  }
  text += outlier_text(view);
  text += weak_perspective_text(view.weak_perspective);
  text += findings_text(view.findings, "  ");
  return text;
}

// Copies the fields that both kinds of estimates have.
template <typename Estimate>
PoseReport common(const Estimate& estimate) {
  PoseReport report;
  report.status = estimate.status;
  report.outliers = estimate.outliers;
  if (estimate.sigma_px > 0) report.sigma_px = estimate.sigma_px;
  report.findings = estimate.findings;
  if (is_answer(estimate.status)) report.hypotheses = estimate.hypotheses;
  return report;
}

}  // namespace

PoseReport reported(const PoseEstimate& estimate) { return common(estimate); }

PoseReport reported(const PoseAndFocalEstimate& estimate, const PoseAndFocalOptions& options) {
  PoseReport report = common(estimate);
  if (is_answer(estimate.status)) {
    report.focal_px = estimate.focal_px;
    report.sigma_focal_px = estimate.sigma_focal_px;
  } else if (estimate.status == Status::focal_not_observable) {
    report.hypotheses = estimate.hypotheses;
    report.weak_perspective = estimate.weak_perspective;
    if (!estimate.hypotheses.empty()) report.prior_focal_px = options.prior_focal_px;
  }
  return report;
}

std::string pose_json(const std::vector<PoseReport>& views) {
  Json list = Json::array();
  for (const PoseReport& view : views) list.push_back(view_json(view));
  const Json answer = {{"views", list}};
  return answer.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string pose_text(const std::vector<PoseReport>& views) {
  std::string text;
  for (const PoseReport& view : views) text += (text.empty() ? "" : "\n") + view_text(view);
  return text;
}

}  // namespace tagcal::tools
