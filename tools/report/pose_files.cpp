#include "report/pose_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "job/camera_input.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "job/terminal.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

constexpr const char* kColumns =
    "image,time_s,status,probability,x_m,y_m,z_m,qw,qx,qy,qz,sigma_x_m,sigma_y_m,sigma_z_m,"
    "sigma_rx_rad,sigma_ry_rad,sigma_rz_rad,focal_px,sigma_focal_px,rms_px,num_inliers,"
    "num_corners,findings\n";

std::string or_empty(const std::optional<double>& value) {
  return value ? fmt::to_string(*value) : "";
}

// From `probability` to sigma_rz_rad.
std::string pose_fields(const PoseHypothesis& hypothesis) {
  const Pose target_from_camera = hypothesis.camera_from_target.inverse();
  const Eigen::Quaterniond q = shown_rotation(target_from_camera);
  const Eigen::Vector3d& t = target_from_camera.translation();
  std::string fields = fmt::format("{},{},{},{},{},{},{},{}", hypothesis.probability, t.x(), t.y(),
                                   t.z(), q.w(), q.x(), q.y(), q.z());
  const auto add = [&](const Eigen::Vector3d& variances) {
    for (const double variance : variances)
      fields += fmt::format(",{}", std::sqrt(std::max(0.0, variance)));
  };
  add(camera_in_target(hypothesis).covariance.diagonal().head<3>());
  add(hypothesis.covariance.diagonal().head<3>());  // about the camera's axes
  return fields;
}

std::string line_of(const PoseReport& view, const PoseHypothesis* hypothesis) {
  std::string codes;
  for (const Finding& finding : view.findings) codes += (codes.empty() ? "" : " ") + finding.code;
  return fmt::format(
      "{},{},{},{},{},{},{},{},{},{}\n", image_field(view.image),
      view.time_s ? fmt::format("{:.6f}", *view.time_s) : "", status_name(view.status),
      hypothesis != nullptr ? pose_fields(*hypothesis) : std::string(13, ','),
      or_empty(view.focal_px), or_empty(view.sigma_focal_px),
      hypothesis != nullptr ? fmt::to_string(hypothesis->rms_px) : "",
      hypothesis != nullptr ? fmt::to_string(view.corners.size() - view.outliers.size()) : "",
      view.corners.size(), codes);
}

std::string pose_csv(const std::vector<PoseReport>& views) {
  std::string csv = kColumns;
  for (const PoseReport& view : views) {
    if (view.hypotheses.empty()) csv += line_of(view, nullptr);
    for (const PoseHypothesis& hypothesis : view.hypotheses) csv += line_of(view, &hypothesis);
  }
  return csv;
}

std::vector<ImagePose> answered_poses(const std::vector<PoseReport>& views) {
  std::vector<ImagePose> poses;
  for (const PoseReport& view : views)
    if (is_answer(view.status))
      poses.push_back(
          {view.image, 0, view.hypotheses.front().camera_from_target, view.time_s, view.findings});
  return poses;
}

// "4 poses of 6 views", and how many of them are one of two.
std::string count_text(std::size_t num_poses, const std::vector<PoseReport>& views) {
  const auto ambiguous = std::ranges::count(views, Status::ambiguous, &PoseReport::status);
  return fmt::format("{} of {}{}", counted(num_poses, "pose"), counted(views.size(), "view"),
                     ambiguous == 0 ? "" : fmt::format(", of {} the likelier of two", ambiguous));
}

std::string ending_of(const std::string& out) {
  return std::filesystem::path(out).extension().string();
}

SeenPose read_seen_pose(const YamlValue& pose) {
  // Files without it have the covariance of the noise as the only one.
  const auto of_noise = pose.find("noise_covariance");
  const YamlValue covariance = of_noise ? *of_noise : pose.at("covariance");
  if (!covariance.is_list())
    covariance.fail_plainly("is missing, the weight of the pose is unknown");
  SeenPose seen{read_pose(pose.at("camera_from_board"))};
  const std::vector<YamlValue> rows = covariance.items(6, 6);
  for (Eigen::Index i = 0; i < 6; ++i) {
    const std::vector<double> row = rows[static_cast<std::size_t>(i)].numbers(6);
    seen.covariance.row(i) = Eigen::Map<const Eigen::Matrix<double, 1, 6>>(row.data());
  }
  return seen;
}

}  // namespace

void check_pose_file(const std::string& out, const PosesAsked& asked) {
  check_text_writable(out);
  const std::string ending = ending_of(out);
  if (ending != ".csv" && ending != ".json" && ending != ".tum" && ending != ".mcap")
    throw Error(fmt::format("--out: must end in .csv, .json, .tum or .mcap, got {}", out));
  if (ending == ".mcap" && !asked.has_camera)
    throw Error(
        fmt::format("--out: {} holds the camera of --camera: take it, or a name in .csv", out));
  if ((ending == ".mcap" || ending == ".tum") && asked.are_of_tags)
    throw Error(fmt::format(
        "--out: {} holds one pose of a picture, and --family has one of each tag: take a name in "
        ".csv",
        out));
}

void write_poses(const std::string& out, const std::string& camera,
                 const std::vector<PoseReport>& views) {
  const std::string_view format = format_of_name(out);
  if (format.empty()) {
    write_whole(out, ending_of(out) == ".csv" ? pose_csv(views) : pose_json(views));
    return say_wrote(out);
  }
  CameraFile file;
  if (!camera.empty()) file = read_one_camera(camera);
  file.poses = answered_poses(views);
  file.frame_of_poses = "target";
  hold_notes(out, write_camera_file(out, file, format));
  say_wrote(out, count_text(file.poses.size(), views));
}

std::vector<HandeyeView> read_pose_file(const std::string& file) {
  constexpr std::size_t kMost = 100'000;  // a limit of work
  std::vector<HandeyeView> views;
  for (const YamlValue& view : YamlValue::read(file).at("views").items(1, kMost)) {
    views.push_back({view.at("image").text(), {}, {}, {}});
    if (const auto time = view.find("time_s"); time && time->is_number())
      views.back().time_s = time->number();
    const std::string status = view.at("status").text();
    if (status != status_name(Status::ok) && status != status_name(Status::ambiguous)) continue;
    views.back().poses.push_back(read_seen_pose(view));
    if (const auto other = view.find("alternative"); other && other->is_map())
      views.back().poses.push_back(read_seen_pose(*other));
  }
  return views;
}

}  // namespace tagcal::tools
