#include "input/lens_input.hpp"

#include <fmt/format.h>

#include "input/camera_input.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/camera_file.hpp"

namespace tagcal::tools {

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
  input.lens.lens = calibration.camera.lens;
  input.image_size = calibration.camera.image_size;
  if (!view.empty()) input.camera_from_world = pose_of_view(file, view);
  if (calibration.covariance.size() == 0 || calibration.model.empty()) {
    input.uncertainty = fmt::format("{} has no covariance: the lens is taken as exact", file);
    return input;
  }
  input.models = std::make_shared<const HeldModels>(calibration.fixed,
                                                    Model::named(calibration.model).lens_type());
  input.lens.model = &input.models->named(calibration.model);
  input.lens.covariance = calibration.covariance;
  input.uncertainty = fmt::format("the covariance of {} is included", file);
  return input;
}

}  // namespace tagcal::tools
