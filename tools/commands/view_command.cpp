#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "draw/view_panels.hpp"
#include "job/arguments.hpp"
#include "job/input.hpp"
#include "job/messages.hpp"
#include "job/plain_text.hpp"
#include "job/view_input.hpp"
#include "report/view_text.hpp"
#include "tagcal/error.hpp"

namespace tagcal::tools {
namespace {

struct Arguments {
  ViewChoice choice;
  std::string at;
  std::string to;     // empty: no line
  double near_m = 0;  // 0: encloses the scene
  double far_m = 0;
  bool json = false;
  bool svg = false;
  bool steps = false;
  bool opengl = false;
};

// Parses "1,2.5,-3" or "3:0"; empty if a part is no number.
std::vector<double> numbers(const std::string& text, char separator) {
  std::vector<double> result;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    const auto value = number_of<double>(std::string_view(text).substr(begin, end - begin));
    if (!value || !std::isfinite(*value)) return {};
    result.push_back(*value);
    begin = end + 1;
  }
  return result;
}

// The first corner; one metre in front of a camera without a scene.
NamedPoint first_point(const Scene& scene, const Pose& camera_from_world) {
  const auto points = points_in_world(scene.boards);
  if (points.empty())
    return {"1 m ahead", {}, camera_from_world.inverse() * Eigen::Vector3d::UnitZ(), {}};
  return named_corner(scene, points.begin()->first).value();
}

// A point as --at or --to (`option`) names it.
NamedPoint named_point(const std::string& option, const std::string& at, const Scene& scene) {
  if (const auto x = numbers(at, ','); x.size() == 3)
    return {fmt::format("({}) in the world", at), {}, {x[0], x[1], x[2]}, {}};
  const auto id = numbers(at, ':');
  const bool whole =
      std::ranges::all_of(id, [](double n) { return n == std::floor(n) && std::abs(n) < 1e9; });
  if (!whole || id.empty() || id.size() > 2)
    throw Error(fmt::format("{}: must be TAG:CORNER or X,Y,Z in metres, got {}", option, at));
  const int corner = id.size() == 2 ? static_cast<int>(id[1]) : 0;
  const auto point = named_corner(scene, {static_cast<int>(id[0]), corner});
  if (!point) throw Error(fmt::format("{}: the scene has no corner {}", option, at));
  return *point;
}

ViewingPipeline pipeline_of(const Arguments& arguments, const Scene& scene, const Pose& pose) {
  NearFar planes = enclosing_planes(scene, pose);
  if (scene.boards.empty()) planes = {0.5, 1.5};  // m; about the point 1 m ahead
  if (arguments.near_m > 0) planes.near_m = arguments.near_m;
  if (arguments.far_m > 0) planes.far_m = arguments.far_m;
  if (!(planes.near_m < planes.far_m))
    throw Error(
        fmt::format("--near: must be < far, got {:g} and {:g} m", planes.near_m, planes.far_m));
  return viewing_pipeline(scene.camera, pose, planes.near_m, planes.far_m);
}

std::string report_text(const Arguments& arguments, const ViewReport& report) {
  if (arguments.json) return view_json(report);
  if (arguments.svg) return view_svg(report);
  return arguments.opengl ? view_opengl(report) : view_text(report, arguments.steps);
}

std::string answer(const Arguments& arguments, const ViewInput& input) {
  const int view = arguments.choice.view;
  const Scene scene = scene_in_view(input.scene, view);
  if (scene.is_rolling())
    throw Error(
        "sensor: readout_ms: the viewing pipeline has one pose: leave it out, or the motion");
  const Pose& pose = *input.camera_from_world;
  const NamedPoint point =
      arguments.at.empty() ? first_point(scene, pose) : named_point("--at", arguments.at, scene);
  const ViewingPipeline pipeline = pipeline_of(arguments, scene, pose);
  ViewReport report{scene,
                    input.image,
                    pipeline,
                    point,
                    followed(point, scene, pipeline),
                    frames_in_view(input.scene, view),
                    input.scene.boards};
  if (!arguments.to.empty()) {
    const NamedPoint to = named_point("--to", arguments.to, scene);
    report.line_to = LineEnd{to, followed(to, scene, pipeline)};
  }
  return report_text(arguments, report);
}

int run(const Arguments& arguments) {
  const ViewInput input = read_view_input(arguments.choice);
  print_warnings(input.warnings);
  if (!input.camera_from_world) {
    print_to_stderr("{}: no pose of the camera\n", input.image);
    return kNoAnswer;
  }
  print_answer(naming(arguments.choice.input, [&] { return answer(arguments, input); }),
               arguments.json || arguments.svg || arguments.opengl);
  return kAnswer;
}

// What is printed, one of these; `to` is for text only.
void add_printed_forms(CLI::App& command, Arguments& arguments, Option& to) {
  const Option steps = add_flag(command, "--steps", arguments.steps,
                                "all named steps: frames, angles, normalising, depth, horizon");
  const Option json = add_flag(command, "--json", arguments.json, "one JSON object on stdout");
  const Option svg =
      add_flag(command, "--svg", arguments.svg,
               "a drawing on stdout: the scene with the view volume, the image, the NDC cube");
  const Option opengl = add_flag(command, "--opengl", arguments.opengl,
                                 "the camera as OpenGL's matrices, C++ to paste");
  Option all[] = {steps, json, svg, opengl};
  for (Option& one : all)
    for (const Option& other : all)
      if (&one < &other) one.excludes(other);
  to.excludes(svg).excludes(opengl);
}

}  // namespace

Command add_view(CLI::App& app) {
  CLI::App* command =
      add_command(app, "view", "the viewing pipeline of one camera, and a point through it");
  const auto arguments = std::make_shared<Arguments>();
  ViewChoice& choice = arguments->choice;
  add_option(*command, "INPUT", choice.input,
             "a scene, the folder of a data set (its truth), or a calibration (no scene)")
      .required();
  add_option(*command, "--camera", choice.camera,
             "for a data set: the camera of this file, and the pose that the view's corners give")
      .text("CAMERA");
  add_option(*command, "--at", arguments->at,
             "the point to follow: a corner of a tag, or a point of the world in metres "
             "(the first corner)")
      .text("TAG:CORNER|X,Y,Z");
  Option to = add_option(*command, "--to", arguments->to,
                         "clips the line from the point of --at to this one");
  to.text("TAG:CORNER|X,Y,Z");
  add_integer(*command, "--view", choice.view, 0, "which camera of the path or the data set (0)");
  add_integer(*command, "--seed", choice.seed, 0, "seed of the path jitter (0)");
  add_positive(*command, "--near", arguments->near_m, "distance of the near plane, m");
  add_positive(*command, "--far", arguments->far_m, "distance of the far plane, m");
  add_printed_forms(*command, *arguments, to);
  add_footer(*command,
             "Example: tagcal view scene.yaml --at 7:2 --svg > view.svg\n"
             "         tagcal view desk --camera camera.yaml --steps\n"
             "         tagcal view camera.yaml --opengl --near 0.1 --far 100");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
