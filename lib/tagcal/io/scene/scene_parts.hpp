#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tagcal/internal/degrees.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"
#include "tagcal/scene/moving_scene.hpp"
#include "tagcal/scene/rig_scene.hpp"
#include "tagcal/scene/scene.hpp"

// Private to io: parts of scene.yaml (docs/reference/formats.md), and values that change over the
// views.

namespace tagcal::internal {

// A day (ms). Source: seconds in a double, which resolve a microsecond within it.
inline constexpr double kMostMilliseconds = 86'400'000;

inline double not_negative_or(const std::optional<YamlValue>& value, double otherwise) {
  return value ? value->not_negative() : otherwise;
}

inline double level_or(const std::optional<YamlValue>& value, double otherwise) {
  return value ? value->number_in(0, 1) : otherwise;
}

inline Eigen::Vector3d vector_or(const std::optional<YamlValue>& value,
                                 const Eigen::Vector3d& otherwise) {
  return value ? read_vector(*value) : otherwise;
}

// A value at times that are spread evenly over [0, 1], linear between them; or one for all times.
template <typename T>
class OverViews {
 public:
  explicit OverViews(std::vector<T> values) : values_(std::move(values)) {}

  const std::vector<T>& values() const { return values_; }
  bool moves() const { return values_.size() > 1; }

  T at(double t) const {
    const double place = t * static_cast<double>(values_.size() - 1);
    const auto i = static_cast<std::size_t>(place);
    if (i + 1 >= values_.size()) return values_.back();
    const double share = place - static_cast<double>(i);
    return (1 - share) * values_[i] + share * values_[i + 1];
  }

 private:
  std::vector<T> values_;  // not empty
};

using NumberOverViews = OverViews<double>;
using VectorOverViews = OverViews<Eigen::Vector3d>;

NumberOverViews degrees_over_views(
    const std::optional<YamlValue>& value);  // in radians; 0 if missing

// [x, y, z], or a list of at most 1000 of them.
VectorOverViews vectors_over_views(const YamlValue& value);

struct SceneCamera {
  Camera camera;
  std::string model;
  bool behind_window = false;  // the path gives the lens of each view
};

SceneCamera read_camera(const YamlValue& value);

// A placement: a pose as read_pose reads it, or one given by angles, by an axis and an angle, by a
// look-at, an orbit or an aircraft, or by a list of elementary steps.
Affine read_placement(const YamlValue& value);
Pose read_rigid_placement(const YamlValue& value);  // throws if it scales

// The frames of a scene, with their motion. Throws unless they are a tree under the world.
std::vector<MovingFrame> read_frames(const YamlValue& top);

// The name of an existing frame under the key `frame`, or the world.
std::string read_frame_of(const YamlValue& part, const std::vector<MovingFrame>& frames);

// The light of a scene. Its key `frame` is left to the caller.
Light read_light(const YamlValue& value);

// The sensor that takes the pictures. Throws also if the camera cannot have such a sensor.
Sensor read_sensor(const YamlValue& value, const Camera& camera);

// The path of the camera. Its key `frame` is left to the caller.
CameraPath read_path(const YamlValue& value, const ImageSize& image_size);

// The number of views under `views`. A path that lists poses has as many, one that may stand still
// has one view unless the file says otherwise.
int read_num_views(const YamlValue& top, const CameraPath& path);

// The placement parent_from_frame by the keys of a path: a camera's axes for look_at and orbit, an
// aircraft's for aircraft.
Pose read_viewpoint(std::string_view kind, const YamlValue& value);

// Reads `rig`, which stands in place of the camera, and the sensors of its cameras into a scene
// whose own sensor has not been read.
void read_rig(const YamlValue& top, RigScene& scene);

}  // namespace tagcal::internal
