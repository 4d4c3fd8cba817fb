// Scene recipes: YAML to the poses of the camera, or of the cameras of a rig.
#include "fuzz/fuzz.hpp"
#include "tagcal/io/scene_file.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tagcal;
  static const fuzz::Scratch scratch;
  const std::filesystem::path file = scratch.write("scene.yaml", fuzz::text_of(data, size));
  fuzz::is_accepted([&] {
    const AnyScene any = read_any_scene(file);
    const auto* rig = std::get_if<RigScene>(&any);
    const std::size_t num_cameras = rig ? rig->cameras.size() : 1;
    for (std::size_t c = 0; c < num_cameras; ++c) {
      if ((rig ? rig->scene : std::get<MovingScene>(any)).settings.num_views > 100)
        return;  // work that was asked for
      const MovingScene scene = rig ? scene_of_camera(*rig, c, 1) : std::get<MovingScene>(any);
      for (const Pose& pose : camera_poses(scene, 1))
        fuzz::require(pose.matrix().allFinite(), "poses are finite");
    }
  });
  return 0;
}
