// Scene recipes: YAML to the poses of the camera.
#include "fuzz/fuzz.hpp"
#include "tagcal/io/scene_file.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tagcal;
  static const fuzz::Scratch scratch;
  const std::filesystem::path file = scratch.write("scene.yaml", fuzz::text_of(data, size));
  fuzz::is_accepted([&] {
    const MovingScene scene = read_moving_scene(file);
    if (scene.settings.num_views > 100) return;  // work that was asked for
    for (const Pose& pose : camera_poses(scene, 1))
      fuzz::require(pose.matrix().allFinite(), "poses are finite");
  });
  return 0;
}
