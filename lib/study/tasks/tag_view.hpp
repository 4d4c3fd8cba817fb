#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "tagcal/detect/families.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/render.hpp"

// Pictures of single tags by the library's own renderer, with their true corners. Private to study.

namespace tagcal::study {

struct TagViewSpec {
  double side_px = 40;
  double tilt_deg = 30;
  double blur_px = 0.8;
  double noise_levels = 2;
  std::string family = "tag36h11";
  int border_bits = 1;
  bool corner_squares = false;  // Kalibr's, 0.3 of the tag wide

  AprilGrid board(int id) const {
    return {1, 1, 1.0, 0.3, id, family, border_bits, corner_squares};
  }
};

struct TagView {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;
  Image8 image;
  Image8 noiseless;
  Camera camera;
};

// One tag on white, black 30, white 220, before a camera.
struct TagScene {
  TagFamilies families;
  Scene scene;
  int id = 0;

  TagScene(const TagViewSpec& spec, Random& random);

  // No value if one of them is not in the lens' domain.
  std::optional<std::array<Eigen::Vector2d, 4>> corners(const Pose& camera_from_world) const;

  TagView view(const Pose& camera_from_world, Random& random) const;
};

// The pose of a tag whose middle is at `distance` along a direction, tilted against the direction
// about an axis at the azimuth, and rolled; radians.
Pose tag_pose(const Eigen::Vector3d& direction, double distance, double tilt_deg,
              const Eigen::Vector2d& azimuth_and_roll);

// Each angle is uniform in [0, 2 pi).
Eigen::Vector2d random_turns(Random& random);

// A tag with the given tilt about a random axis and a random roll, within a pixel of the middle of
// the picture.
TagView rendered_tag(const TagViewSpec& spec, Random& random);

}  // namespace tagcal::study
