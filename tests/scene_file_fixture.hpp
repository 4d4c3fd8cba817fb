#pragma once

#include "file_fixture.hpp"
#include "tagcal/io/scene_file.hpp"

// Scenes as texts, and reading them.

namespace tagcal {

inline const std::string kTarget =
    "target_type: aprilgrid\ntagCols: 2\ntagRows: 2\ntagSize: 0.1\ntagSpacing: 0.25\n";
inline const std::string kScene =
    "camera:\n  image_size: [640, 480]\n  model: opencv5\n  fx: 500\n  fy: 501\n  cx: 320\n"
    "  distortion: [-0.1, 0.01]\n"
    "boards:\n  - file: target.yaml\n"
    "  - {target: {target_type: tags, tags: [{id: 9, size: 0.2}]}, first_id: 20,\n"
    "     world_from_board: {translation_m: [1, 2, 3]}}\n"
    "occluders:\n  - {corners: [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], level: 0.4}\n"
    "path:\n  type: dome\n  min_distance_m: 0.5\n  max_distance_m: 1.5\n  min_elevation_deg: 30\n"
    "views: 7\n"
    "jitter: {position_m: 0.1, target_m: 0.2, roll_deg: 90}\n"
    "sensor: {exposure: 1.1, blur_px: 0.7, noise_levels: 2, bits: 16, gamma: 0.45}\n"
    "background_level: 0.1\npaper_level: 1\nink_level: 0\nink_spread_m: -0.0002\n"
    "paper_margin_m: 0.05\n";

class SceneFile : public FileTest {
 protected:
  SceneFile() { write("target.yaml", kTarget); }

  Scene read(const std::string& text) { return read_scene(write("scene.yaml", text), &warnings_); }
  std::string error(const std::string& text) {
    return error_about(folder_.string() + "/", [&] { read(text); });
  }
  Scene with_path(const std::string& path) {
    const std::size_t begin = kScene.find("path:"), end = kScene.find("jitter:");
    return read(kScene.substr(0, begin) + path + kScene.substr(end));
  }
  Scene with_camera(const std::string& camera) {
    return read("camera: " + camera + "\n" + kScene.substr(kScene.find("boards:")));
  }

  std::vector<std::string> warnings_;
};

}  // namespace tagcal
