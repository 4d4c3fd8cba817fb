#include "report/pose_report.hpp"

#include "job/find_corners.hpp"
#include "job/plain_text.hpp"
#include "job/terminal.hpp"
#include "report/findings.hpp"
#include "report/json_parts.hpp"
#include "tagcal/internal/text.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/internal/degrees.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

constexpr std::size_t kOutliersShown = 12;

using internal::degrees;

Json rotation_json(const Pose& pose) {
  const Eigen::Quaterniond q = shown_rotation(pose);
  return {q.w(), q.x(), q.y(), q.z()};
}

Json shown_pose_json(const Pose& pose) {
  const Vector3d& t = pose.translation();
  return {{"rotation", rotation_json(pose)}, {"translation_m", {t.x(), t.y(), t.z()}}};
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
  return {{"camera_from_board", shown_pose_json(other.camera_from_target)},
          {"covariance", matrix_json(other.covariance)},
          {"noise_covariance", matrix_json(other.noise_covariance)},
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
          {"time_s", optional_json(view.time_s)},
          {"status", status_name(view.status)},
          {"camera_from_board", best ? shown_pose_json(best->camera_from_target) : Json()},
          {"covariance", best ? matrix_json(best->covariance) : Json()},
          {"noise_covariance", best ? matrix_json(best->noise_covariance) : Json()},
          {"camera_in_target", best ? camera_json(*best) : Json()},
          {"focal_px", optional_json(view.focal_px)},
          {"sigma_focal_px", optional_json(view.sigma_focal_px)},
          {"prior_focal_px", optional_json(view.prior_focal_px)},
          {"rms_px", best ? Json(best->rms_px) : Json()},
          {"num_inliers", best ? Json(num_inliers) : Json()},
          {"num_corners", view.corners.size()},
          {"outliers", outliers_json(view)},
          {"probability", best ? Json(best->probability) : Json()},
          {"alternative", alternative_json(view.hypotheses)},
          {"weak_perspective", weak_perspective_json(view.weak_perspective)},
          {"sigma_px", optional_json(view.sigma_px)},
          {"findings", findings_json(view.findings)},
          {"warnings", sentences(view.findings)}};
}

std::string line(std::string_view name, const std::string& value) {
  return fmt::format("  {:<11}{}\n", name, value);
}

// "camera at   0.2000  -0.2000  0.4000 m +- 0.0003 0.0003 0.0004   x, y, z": three numbers with
// their standard deviations, which may be unknown (NaN).
std::string vector_line(std::string_view name, const Vector3d& values, const Vector3d& sigmas,
                        std::string_view unit, std::string_view meaning) {
  std::string numbers, deviations;
  for (int i = 0; i < 3; ++i) {
    const Measured m = measured(values[i], sigmas[i]);
    numbers += fmt::format(" {:>10}", m.value);
    deviations += " " + (m.sigma.empty() ? "?" : m.sigma);
  }
  return line(name, fmt::format("{} {:<3} +-{:<22}  {}", numbers, unit, deviations, meaning));
}

Vector3d degrees(const Vector3d& rad) { return rad * degrees(1); }

std::string quaternion_line(const Pose& pose) {
  const Eigen::Quaterniond q = shown_rotation(pose);
  return line("rotation", fmt::format("{:9.6f} {:9.6f} {:9.6f} {:9.6f}  w, x, y, z", q.w(), q.x(),
                                      q.y(), q.z()));
}

Vector3d roll_pitch_yaw_rad(const Pose& pose) {
  const RollPitchYaw angles = roll_pitch_yaw(shown_rotation(pose));
  return {angles.roll_rad, angles.pitch_rad, angles.yaw_rad};
}

// Where the camera is in the target's frame, and the target in the camera's.
std::string hypothesis_lines(const PoseHypothesis& hypothesis, bool verbose) {
  const CameraInTarget camera = camera_in_target(hypothesis);
  const Vector6d sigma = sigmas_of(camera.covariance);
  std::string text = vector_line("camera at", camera.position_m, sigma.head<3>(), "m", "x, y, z");
  text += vector_line("looks to",
                      degrees(Vector3d(camera.azimuth_rad, camera.elevation_rad, camera.roll_rad)),
                      degrees(Vector3d(sigma.tail<3>())), "deg", "az., el., roll");
  const Vector6d step = sigmas_of(hypothesis.covariance);
  const Pose& pose = hypothesis.camera_from_target;
  text += vector_line("target at", pose.translation(), step.tail<3>(), "m", "x, y, z");
  if (!verbose) return text;
  text += quaternion_line(pose);
  return text + vector_line("turned by", degrees(roll_pitch_yaw_rad(pose)),
                            degrees(Vector3d(step.head<3>())), "deg", "roll, pitch, yaw");
}

std::string poses_text(const PoseReport& view, bool verbose) {
  if (view.hypotheses.size() < 2) return hypothesis_lines(view.hypotheses.front(), verbose);
  std::string text;
  for (std::size_t i = 0; i < view.hypotheses.size(); ++i) {
    const PoseHypothesis& h = view.hypotheses[i];
    text +=
        fmt::format("  {} with probability {:.4f}, rms {} px\n",
                    i == 0 ? "likelier pose" : "other pose", h.probability, two_digits(h.rms_px));
    text += hypothesis_lines(h, verbose);
  }
  return text;
}

std::string focal_text(const PoseReport& view) {
  if (view.focal_px) {
    const Measured m = measured(*view.focal_px, view.sigma_focal_px.value_or(std::nan("")));
    return line("focal", fmt::format("{} +- {} px", m.value, m.sigma));
  }
  if (view.prior_focal_px)
    return line("focal", fmt::format("not observable; the pose is for {:g} px, as stated",
                                     *view.prior_focal_px));
  return view.status == Status::focal_not_observable ? line("focal", "not observable") : "";
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
  return line("rejected", names + "  tag:corner");
}

std::string weak_perspective_text(const std::vector<WeakPerspectivePose>& poses) {
  std::string text;
  for (const WeakPerspectivePose& weak : poses) {
    const Vector3d& t = weak.camera_from_target.translation();
    text += fmt::format("  under weak perspective, rms {} px\n", two_digits(weak.rms_px));
    text += quaternion_line(weak.camera_from_target);
    text += line("translation", fmt::format("{:9.6f} {:9.6f} m  x, y", t.x(), t.y()));
    text += line("scale", fmt::format("{:.4f} px/m", weak.scale_px_per_m));
  }
  return text;
}

// "000.png: OK, rms 0.11 px over 32 of 33 corners", or "000.png: NO ANSWER: " and the reason.
std::string verdict_text(const PoseReport& view) {
  if (!is_answer(view.status)) {
    const Finding* const reason = reason_of(view.findings);
    return wrapped(view.image + ": " + toned(Tone::bad, "NO ANSWER:") + " ",
                   reason == nullptr ? status_name(view.status) : reason->sentence, 2);
  }
  const bool is_ambiguous = view.status == Status::ambiguous;
  return fmt::format("{}: {}, rms {} px over {} of {} corners\n", view.image,
                     is_ambiguous ? toned(Tone::caution, "AMBIGUOUS") + ": two poses fit"
                                  : toned(Tone::good, "OK"),
                     two_digits(view.hypotheses[0].rms_px),
                     view.corners.size() - view.outliers.size(), view.corners.size());
}

std::string view_text(const PoseReport& view, bool verbose) {
  std::string text = verdict_text(view);
  std::vector<Finding> findings = without_reason(view.findings);
  // Those of the files are the same for all views, and are printed once.
  std::erase_if(findings, [](const Finding& f) {
    return f.code == code::input.name || f.code == code::lens_without_covariance.name;
  });
  text += findings_text(findings, "  ") + focal_text(view);
  if (!view.cameras.empty())
    text += line("seen by", fmt::format("{}", fmt::join(view.cameras, ", ")));
  if (!view.hypotheses.empty()) {
    text += poses_text(view, verbose);
    if (verbose)
      text += line("noise", view.sigma_px ? two_digits(*view.sigma_px) + " px per coordinate"
                                          : "each corner's own covariance");
  }
  return text + outlier_text(view) + weak_perspective_text(view.weak_perspective);
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

void report_mistakes(const std::vector<TargetMistake>& mistakes, PoseReport& report) {
  for (const TargetMistake& mistake : mistakes)
    add(report.findings, mistake.moves_corners ? code::no_consensus : code::input,
        "the pictures and the target file do not agree: " + mistake.text());
  if (!wrong_target(mistakes)) return;
  report.status = judge(report.findings);
  report.hypotheses.clear();
  report.focal_px.reset();
}

Eigen::Quaterniond shown_rotation(const Pose& pose) {
  Eigen::Quaterniond q = pose.rotation();
  if (q.w() < 0) q.coeffs() *= -1;
  return q;
}

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
  for (const PoseReport& view : views) {
    list.push_back(view_json(view));
    if (!view.cameras.empty()) list.back()["cameras"] = view.cameras;
  }
  const Json answer = {{"views", list}};
  return json_text(answer);
}

std::string pose_text(const std::vector<PoseReport>& views, bool verbose) {
  return internal::joined(views, "\n",
                          [&](const PoseReport& view) { return view_text(view, verbose); });
}

}  // namespace tagcal::tools
