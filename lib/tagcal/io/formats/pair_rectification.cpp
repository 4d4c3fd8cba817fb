#include "tagcal/io/formats/opencv_format.hpp"

#include "tagcal/error.hpp"
#include "tagcal/reproject/rectify.hpp"

namespace tagcal::internal {

void set_rectification(CameraFile& file) {
  if (file.cameras.size() != 2) return;
  KnownRig rig;
  for (const FileCamera& camera : file.cameras) {
    if (!camera.camera_from_rig) return;
    rig.cameras.push_back(
        {camera.name, {nullptr, camera.calibration.camera, {}}, *camera.camera_from_rig, {}});
  }
  try {
    const RectifiedPair pair = rectify(rig, 0, 1, {.alpha = 0});
    for (std::size_t k = 0; k < 2; ++k)
      file.cameras[k].rectification =
          FileCamera::Rectification{pair.camera_from_rectified[k].rotation_matrix().transpose(),
                                    projection_matrix(pair, k), disparity_to_depth(pair)};
  } catch (const Error& error) {
    file.notes.push_back(std::string("the pair is not rectified: ") + error.what());
  }
}

}  // namespace tagcal::internal
