#include "tagcal/io/handeye_file.hpp"

#include <fmt/format.h>

#include <cassert>

#include "tagcal/internal/text.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/formats/tagcal_format.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal {
using namespace internal;

std::string mount_name(CameraMount mount) { return mount == CameraMount::hand ? "hand" : "base"; }
std::string holder_name(CameraMount mount) { return mount == CameraMount::hand ? "base" : "hand"; }

std::string handeye_yaml(const HandeyeEstimate& handeye) {
  assert(is_answer(handeye.status));
  std::string text =
      fmt::format("%YAML:1.0\n---\nstatus: {}\nmount: {}\n", text_yaml(status_name(handeye.status)),
                  text_yaml(mount_name(handeye.mount)));
  text += fmt::format("mount_from_camera: {}\n", pose_yaml(handeye.mount_from_camera));
  text += fmt::format("holder_from_board: {}\n", pose_yaml(handeye.holder_from_board));
  text += matrix_yaml("covariance", handeye.covariance);
  const auto add = [&](const char* key, double value) {
    text += fmt::format("{}: {}\n", key, number_yaml(value));
  };
  add("board_scale", handeye.board_scale);
  add("sigma_board_scale", handeye.sigma_board_scale);
  add("robot_sigma_m", handeye.robot_sigma_m);
  add("robot_sigma_rad", handeye.robot_sigma_rad);
  add("degrees_of_freedom", handeye.degrees_of_freedom);
  add("axis_spread_rad", handeye.axis_spread_rad);
  add("board_spread_m", handeye.board_spread_m);
  add("rms_px", handeye.rms_px);
  text += fmt::format("num_views: {}\nnum_rejected: {}\n", handeye.views.size(),
                      handeye.rejected.size());
  if (handeye.time_offset_s) add("time_offset_s", *handeye.time_offset_s);
  return text + findings_yaml(handeye.findings);
}

std::string handeye_ros_text(const HandeyeEstimate& handeye) {
  assert(is_answer(handeye.status));
  const Eigen::Vector3d t = handeye.mount_from_camera.translation();
  const Eigen::Quaterniond q = handeye.mount_from_camera.rotation();
  const std::string frame = mount_name(handeye.mount);
  const auto number = [](double value) { return dotted_number(value); };
  return fmt::format(
      "# ros2 run tf2_ros static_transform_publisher --x {0} --y {1} --z {2} --qx {3} --qy {4} "
      "--qz {5} --qw {6} --frame-id {7} --child-frame-id camera\n"
      "header:\n  frame_id: {7}\nchild_frame_id: camera\ntransform:\n"
      "  translation: {{x: {0}, y: {1}, z: {2}}}\n"
      "  rotation: {{x: {3}, y: {4}, z: {5}, w: {6}}}\n",
      number(t.x()), number(t.y()), number(t.z()), number(q.x()), number(q.y()), number(q.z()),
      number(q.w()), frame);
}

}  // namespace tagcal
