#include "tagcal/io/formats/colmap.hpp"

#include <fmt/format.h>

#include <map>

#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

// The pictures of one instant: those that see the rig at the same pose, one a camera.
struct ColmapFrame {
  Pose rig_from_world;
  std::map<std::size_t, std::size_t> images;  // by camera
};

std::vector<ColmapFrame> frames_of(const CameraFile& file, const ColmapRig& rig) {
  constexpr double kSame = 1e-9;  // rad and m: rounding
  std::vector<ColmapFrame> frames;
  std::multimap<double, std::size_t> by_x;  // frames by the first coordinate
  for (std::size_t i = 0; i < file.poses.size(); ++i) {
    const std::size_t camera = file.poses[i].camera;
    const Pose pose = rig.camera_from_rig[camera].inverse() * file.poses[i].camera_from_world;
    const double x = pose.translation().x();
    std::optional<std::size_t> frame;
    for (auto it = by_x.lower_bound(x - kSame); it != by_x.upper_bound(x + kSame); ++it)
      if (minus(frames[it->second].rig_from_world, pose).norm() < kSame &&
          !frames[it->second].images.contains(camera))
        frame = it->second;
    if (!frame) {
      frame = frames.size();
      frames.push_back({pose, {}});
      by_x.emplace(x, *frame);
    }
    frames[*frame].images[camera] = i;
  }
  return frames;
}

}  // namespace

std::optional<ColmapRig> colmap_rig(const CameraFile& file) {
  ColmapRig rig;
  if (file.cameras.size() < 2) return std::nullopt;
  for (std::size_t i = 0; i < file.cameras.size(); ++i) {
    const auto& place = file.cameras[i].camera_from_rig;
    if (!place) return std::nullopt;
    if (!rig.is_reference_frame && minus(*place, Pose()).isZero()) {
      rig.reference = i;
      rig.is_reference_frame = true;
    }
  }
  const Pose rig_from_reference = file.cameras[rig.reference].camera_from_rig->inverse();
  for (const FileCamera& camera : file.cameras)
    rig.camera_from_rig.push_back(*camera.camera_from_rig * rig_from_reference);
  rig.camera_from_rig[rig.reference] = Pose();
  return rig;
}

void note_reference(const CameraFile& file, const ColmapRig& rig, std::vector<std::string>& notes) {
  if (!rig.is_reference_frame)
    notes.push_back(
        fmt::format("dropped: the place of the cameras on the {}: the rig's frame is {}",
                    file.rig_is_imu ? "IMU" : "rig", shown(file.cameras[rig.reference].name)));
}

std::string colmap_pose(const Pose& pose) {
  const Eigen::Quaterniond q = pose.rotation();
  const Eigen::Vector3d& t = pose.translation();
  return fmt::format("{} {} {} {} {} {} {}", q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z());
}

std::string colmap_rigs_text(const CameraFile& file, const ColmapRig& rig) {
  std::string text = fmt::format(
      "# RIG_ID, NUM_SENSORS, REF_SENSOR_TYPE, REF_SENSOR_ID, SENSORS[] as (SENSOR_TYPE, "
      "SENSOR_ID, HAS_POSE, [QW, QX, QY, QZ, TX, TY, TZ])\n1 {} CAMERA {}",
      file.cameras.size(), rig.reference + 1);
  for (std::size_t i = 0; i < file.cameras.size(); ++i)
    if (i != rig.reference)
      text += fmt::format(" CAMERA {} 1 {}", i + 1, colmap_pose(rig.camera_from_rig[i]));
  return text + "\n";
}

std::string colmap_frames_text(const CameraFile& file, const ColmapRig& rig) {
  std::string text =
      "# FRAME_ID, RIG_ID, RIG_FROM_WORLD[QW, QX, QY, QZ, TX, TY, TZ], NUM_DATA_IDS, DATA_IDS[] as "
      "(SENSOR_TYPE, SENSOR_ID, DATA_ID)\n";
  const std::vector<ColmapFrame> frames = frames_of(file, rig);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    text += fmt::format("{} 1 {} {}", f + 1, colmap_pose(frames[f].rig_from_world),
                        frames[f].images.size());
    for (const auto& [camera, image] : frames[f].images)
      text += fmt::format(" CAMERA {} {}", camera + 1, image + 1);
    text += "\n";
  }
  return text;
}

}  // namespace tagcal::internal
