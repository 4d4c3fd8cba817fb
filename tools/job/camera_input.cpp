#include "job/camera_input.hpp"

#include <fmt/format.h>

#include "job/messages.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/camera_file.hpp"

namespace tagcal::tools {

CalibrationFile read_camera(const std::string& file_and_name) {
  const CameraFile file = read_one_camera(file_and_name);
  CalibrationFile camera = usable_camera(file, file_and_name);
  hold_notes(file_and_name, file.notes);
  return camera;
}

void hold_notes(const std::string& name, const std::vector<std::string>& notes) {
  for (const std::string& note : notes) hold_note(fmt::format("{}: {}", name, note));
}

Pose pose_of_view(const std::string& file, const std::string& name) {
  const CameraFile content = read_one_camera(file);
  if (content.poses.empty()) throw Error(fmt::format("--view: {} has no views", file));
  for (const ImagePose& pose : content.poses)
    if (pose.image == name) return pose.camera_from_world;
  throw Error(fmt::format("--view: {} has no {}", file, name));
}

LensInput read_lens(const std::string& file, const std::string& view) {
  const CalibrationFile calibration = read_camera(file);
  LensInput input;
  input.camera = uncertain_camera(calibration);
  if (!view.empty()) input.camera_from_world = pose_of_view(file, view);
  input.uncertainty = input.camera.model
                          ? fmt::format("the covariance of {} is included", file)
                          : fmt::format("{} has no covariance: the lens is taken as exact", file);
  return input;
}

}  // namespace tagcal::tools
