#include "tagcal/io/scene/scene_parts.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tagcal/error.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector3d;

// One elementary transform at time t.
struct Step {
  std::function<Affine(double t)> at;
  bool moves = false;
};

// The product of steps, the first one outermost: steps are read from the parent to the frame.
Affine product(const std::vector<Step>& steps, double t) {
  Affine result = Affine::Identity();
  for (const Step& step : steps) result = result * step.at(t);
  return result;
}

Step rotation_step(const NumberOverViews& angle, const Vector3d& axis, const Vector3d& point) {
  return {[=](double t) { return affine(rotation_about_line(point, axis, angle.at(t))); },
          angle.moves()};
}

Step turning_step(const YamlValue& value) {
  value.allow_only({"rotate_deg", "axis", "point_m"});
  const Vector3d axis = read_vector(value.at("axis"));
  if (axis.isZero()) value.at("axis").fail_plainly("must not be zero");
  return rotation_step(degrees_over_views(value.at("rotate_deg")), axis,
                       vector_or(value.find("point_m"), Vector3d::Zero()));
}

// A number, or one for each axis.
Step scaling_step(const YamlValue& value) {
  const VectorOverViews scale = value.is_list()
                                    ? vectors_over_views(value)
                                    : VectorOverViews({Vector3d::Constant(value.number())});
  for (const Vector3d& factor : scale.values())
    if ((factor.array() == 0).any()) value.fail("must not be zero");
  return {[=](double t) { return scaling(scale.at(t)); }, scale.moves()};
}

Step read_step(const YamlValue& value) {
  if (value.find("rotate_deg")) return turning_step(value);
  value.allow_only({"translate_m", "rotate_x_deg", "rotate_y_deg", "rotate_z_deg", "scale"});
  const auto offset = value.find("translate_m"), factors = value.find("scale");
  std::vector<Step> steps;
  if (offset) {
    const VectorOverViews by = vectors_over_views(*offset);
    steps.push_back({[=](double t) { return affine(translation(by.at(t))); }, by.moves()});
  }
  if (factors) steps.push_back(scaling_step(*factors));
  for (const auto& [key, axis] : {std::pair{"rotate_x_deg", Vector3d::UnitX()},
                                  {"rotate_y_deg", Vector3d::UnitY()},
                                  {"rotate_z_deg", Vector3d::UnitZ()}})
    if (const auto angle = value.find(key))
      steps.push_back(rotation_step(degrees_over_views(angle), axis, Vector3d::Zero()));
  if (steps.size() != 1)
    value.fail_plainly(
        "must be one step: translate_m, rotate_x_deg, rotate_y_deg, rotate_z_deg, rotate_deg "
        "with axis, or scale");
  return steps[0];
}

std::vector<Step> read_steps(const YamlValue& value) {
  std::vector<Step> steps;
  for (const YamlValue& item : value.items(1, limits::kMaxSteps)) steps.push_back(read_step(item));
  return steps;
}

Affine still_product(const YamlValue& value) {
  for (const YamlValue& item : value.items(1, limits::kMaxSteps))
    if (read_step(item).moves)
      item.fail_plainly("changes over the views: that belongs under motion");
  return product(read_steps(value), 0);
}

Pose angles_pose(const YamlValue& value) {
  value.allow_only({"roll_pitch_yaw_deg", "translation_m"});
  const Vector3d angles = read_vector(value.at("roll_pitch_yaw_deg"));
  return {
      rotation_from_roll_pitch_yaw({radians(angles.x()), radians(angles.y()), radians(angles.z())}),
      vector_or(value.find("translation_m"), Vector3d::Zero())};
}

Pose axis_pose(const YamlValue& value) {
  value.allow_only({"axis", "angle_deg", "translation_m"});
  const Vector3d axis = read_vector(value.at("axis"));
  if (axis.isZero()) value.at("axis").fail_plainly("must not be zero");
  return translation(vector_or(value.find("translation_m"), Vector3d::Zero())) *
         rotation_about_axis(axis, radians(value.at("angle_deg").number()));
}

Pose three_points_pose(const YamlValue& value) {
  value.allow_only({"three_points_m"});
  const YamlValue list = value.at("three_points_m");
  const std::vector<YamlValue> points = list.items(3, 3);
  try {
    return world_from_three_points(read_vector(points[0]), read_vector(points[1]),
                                   read_vector(points[2]));
  } catch (const Error& error) {
    if (std::string_view(error.what()).starts_with(value.file())) throw;
    list.fail_plainly("must not lie on a line");
  }
}

bool is_matrix(const YamlValue& value) { return value.items(1, limits::kMaxSteps)[0].is_list(); }

MovingFrame read_frame(const YamlValue& value) {
  value.allow_only({"name", "parent", "pose", "scale"});
  MovingFrame frame;
  frame.name = value.at("name").text();
  if (const auto parent = value.find("parent")) frame.parent = parent->text();
  Affine placed = Affine::Identity();
  if (const auto pose = value.find("pose")) placed = read_placement(*pose);
  if (const auto scale = value.find("scale")) {
    const Step step = scaling_step(*scale);
    if (step.moves) scale->fail_plainly("changes over the views: that belongs under motion");
    placed = placed * step.at(0);
  }
  frame.parent_from_frame = [placed](double) { return placed; };
  return frame;
}

void read_motion(const YamlValue& value, std::vector<MovingFrame>& frames) {
  value.allow_only({"frame", "steps"});
  const YamlValue name = value.at("frame");
  const auto frame = std::ranges::find(frames, name.text(), &MovingFrame::name);
  if (frame == frames.end()) name.fail("must be the name of one of the frames");
  if (frame->moves) name.fail("must differ from the frames before it");
  const std::vector<Step> steps = read_steps(value.at("steps"));
  frame->moves = true;
  frame->parent_from_frame = [still = frame->parent_from_frame(0), steps](double t) {
    return still * product(steps, t);
  };
}

}  // namespace

Affine read_placement(const YamlValue& value) {
  if (value.is_list()) return is_matrix(value) ? affine(read_pose(value)) : still_product(value);
  if (value.find("roll_pitch_yaw_deg")) return affine(angles_pose(value));
  if (value.find("axis")) return affine(axis_pose(value));
  if (value.find("three_points_m")) return affine(three_points_pose(value));
  for (const std::string_view key : {"look_at", "orbit", "aircraft"})
    if (const auto placement = value.find(key)) {
      value.allow_only({key});
      return affine(read_viewpoint(key, *placement));
    }
  return affine(read_pose(value));
}

Pose read_rigid_placement(const YamlValue& value) {
  if (value.is_map() && (value.find("rotation") || value.find("translation_m")) &&
      !value.find("axis") && !value.find("roll_pitch_yaw_deg"))
    return read_pose(value);  // to the last bit
  try {
    return rigid(read_placement(value));
  } catch (const Error& error) {
    if (std::string_view(error.what()).starts_with(value.file())) throw;
    value.fail_plainly("must be rigid: without a scale");
  }
}

std::vector<MovingFrame> read_frames(const YamlValue& top) {
  MovingScene scene;
  if (const auto list = top.find("frames"))
    for (const YamlValue& item : list->items(0, limits::kMaxFrames))
      scene.frames.push_back(read_frame(item));
  if (const auto motion = top.find("motion"))
    for (const YamlValue& item : motion->items(0, limits::kMaxFrames))
      read_motion(item, scene.frames);
  top.within([&] { frames_in_view(scene, 0); });  // an error begins with "frames: "
  return scene.frames;
}

std::string read_frame_of(const YamlValue& part, const std::vector<MovingFrame>& frames) {
  const auto name = part.find("frame");
  if (!name || name->text() == kWorldFrame) return kWorldFrame;
  if (std::ranges::find(frames, name->text(), &MovingFrame::name) == frames.end())
    name->fail("must be world or the name of one of the frames");
  return name->text();
}

}  // namespace tagcal::internal
