#include "tagcal/io/rig_calibration_file.hpp"

#include <fmt/format.h>

#include <cassert>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/formats/tagcal_format.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"
#include "tagcal/uncertainty/uncertain_camera.hpp"

namespace tagcal {
using namespace internal;
namespace {

// A camera of the rig as in a file of its own: what the rig says of its lens.
FileCamera file_camera_of(const RigCameraEstimate& camera) {
  FileCamera file;
  file.name = camera.name;
  file.camera_from_rig = camera.camera_from_rig;
  file.calibration.camera = camera.camera.camera;
  file.calibration.model = camera.model;
  file.calibration.fixed = camera.own.fixed;
  file.calibration.seen = camera.own.seen;
  if (is_answer(camera.own.status)) file.calibration.camera_error_px = camera.error_px;
  if (camera.camera.model) {
    const HeldModels models(file.calibration.fixed, camera.camera.model->kind());
    file.calibration.covariance = covariance_by(models.named(camera.model), camera.camera);
    file.calibration.sigmas = lens_sigmas(camera.camera);
    file.calibration.claim_model = camera.camera.model->name();
    file.calibration.claim_covariance = camera.camera.covariance;
  }
  return file;
}

}  // namespace

std::string rig_yaml(const RigCalibration& rig) {
  assert(is_answer(rig.status));
  std::string text = "%YAML:1.0\n---\n" + cameras_yaml(camera_file(rig).cameras);
  text += fmt::format("status: {}\nrms_px: {}\nnum_instants: {}\nnum_rejected_instants: {}\n",
                      text_yaml(status_name(rig.status)), number_yaml(rig.rms_px),
                      rig.instants.size(), rig.rejected_instants.size());
  if (rig.boards.size() > 1) text += "boards:\n";
  for (std::size_t b = 0; b < rig.boards.size() && rig.boards.size() > 1; ++b)
    text += fmt::format("   - world_from_board: {}\n", pose_yaml(rig.boards[b].world_from_board));
  return text + matrix_yaml("joint_covariance", rig.covariance) + findings_yaml(rig.findings);
}

CameraFile camera_file(const RigCalibration& rig) {
  assert(is_answer(rig.status));
  CameraFile file;
  file.format = "tagcal";
  for (const RigCameraEstimate& camera : rig.cameras) {
    file.cameras.push_back(file_camera_of(camera));
    file.cameras.back().overlaps.emplace();
  }
  for (const RigPair& pair : rig.pairs) {
    if (pair.num_instants == 0) continue;
    file.cameras[pair.a].overlaps->push_back(pair.b);
    file.cameras[pair.b].overlaps->push_back(pair.a);
  }
  file.rig_covariance = known_rig(rig).covariance;
  file.findings = rig.findings;
  return file;
}

KnownRig known_rig(const CameraFile& file, const std::string& name) {
  KnownRig rig;
  for (const FileCamera& camera : file.cameras) {
    if (!camera.camera_from_rig)
      throw Error(fmt::format(
          "{}: has no place of {} in a rig: name a file that has it, such as rig.yaml "
          "of tagcal rig",
          name, camera.name.empty() ? "its camera" : "the camera " + shown(camera.name)));
    const CameraFile alone{file.format, {camera}, {}, {}, {}};
    const CalibrationFile& usable = usable_camera(alone, name + ":" + camera.name);
    rig.cameras.push_back(
        {camera.name, uncertain_camera(usable), *camera.camera_from_rig, usable.camera_error_px});
  }
  rig.covariance = file.rig_covariance;
  return rig;
}

}  // namespace tagcal
