#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "input/arguments.hpp"
#include "input/input.hpp"
#include "report/view_report.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/scene_file.hpp"

namespace tagcal::tools {
namespace {

struct Arguments {
  std::string scene;
  std::string at;
  int view = 0;
  int seed = 0;
  double near_m = 0;  // 0: encloses the scene
  double far_m = 0;
  bool json = false;
  bool svg = false;
};

// Parses "1,2.5,-3" or "3:0"; empty if a part is no number.
std::vector<double> numbers(const std::string& text, char separator) {
  std::vector<double> result;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    double value = 0;
    const char* last = text.data() + end;
    const auto [stop, error] = std::from_chars(text.data() + begin, last, value);
    if (error != std::errc() || stop != last || !std::isfinite(value)) return {};
    result.push_back(value);
    begin = end + 1;
  }
  return result;
}

NamedPoint first_corner(const Scene& scene) {
  const auto points = points_in_world(scene.boards);
  if (points.empty()) return {"world origin", {}, Eigen::Vector3d::Zero(), {}};
  return named_corner(scene, points.begin()->first).value();
}

NamedPoint point_to_follow(const std::string& at, const Scene& scene) {
  if (at.empty()) return first_corner(scene);
  if (const auto x = numbers(at, ','); x.size() == 3)
    return {fmt::format("({}) in the world", at), {}, {x[0], x[1], x[2]}, {}};
  const auto id = numbers(at, ':');
  const bool whole =
      std::ranges::all_of(id, [](double n) { return n == std::floor(n) && std::abs(n) < 1e9; });
  if (!whole || id.empty() || id.size() > 2)
    throw Error(fmt::format("--at: must be TAG:CORNER or X,Y,Z in metres, got {}", at));
  const int corner = id.size() == 2 ? static_cast<int>(id[1]) : 0;
  const auto point = named_corner(scene, {static_cast<int>(id[0]), corner});
  if (!point) throw Error(fmt::format("--at: the scene has no corner {}", at));
  return *point;
}

ViewingPipeline pipeline_of(const Arguments& arguments, const Scene& scene, const Pose& pose) {
  NearFar planes = enclosing_planes(scene, pose);
  if (arguments.near_m > 0) planes.near_m = arguments.near_m;
  if (arguments.far_m > 0) planes.far_m = arguments.far_m;
  if (!(planes.near_m < planes.far_m))
    throw Error(
        fmt::format("--near: must be < far, got {:g} and {:g} m", planes.near_m, planes.far_m));
  return viewing_pipeline(scene.camera, pose, planes.near_m, planes.far_m);
}

int run(const Arguments& arguments) {
  std::vector<std::string> warnings;
  const MovingScene moving = read_moving_scene(arguments.scene, &warnings);
  const int num_views = moving.settings.num_views;
  if (arguments.view >= num_views)
    throw Error(fmt::format("--view: must be {} at most, of the views in {}, got {}", num_views - 1,
                            arguments.scene, arguments.view));
  const Scene scene = scene_in_view(moving, arguments.view);
  const auto poses = camera_poses(moving, static_cast<std::uint64_t>(arguments.seed));
  const Pose& pose = poses[static_cast<std::size_t>(arguments.view)];
  const NamedPoint point = point_to_follow(arguments.at, scene);
  const ViewingPipeline pipeline = pipeline_of(arguments, scene, pose);
  const ViewReport report{scene, image_name(arguments.view), pipeline, point,
                          followed(point, scene, pipeline)};
  print_warnings(warnings);
  print_result(arguments.json  ? view_json(report)
               : arguments.svg ? view_svg(report)
                               : view_text(report));
  return kAnswer;
}

}  // namespace

Command add_view(CLI::App& app) {
  CLI::App* command =
      add_command(app, "view", "the viewing pipeline of one camera, and a point through it");
  const auto arguments = std::make_shared<Arguments>();
  add_option(*command, "SCENE.yaml", arguments->scene, "the scene").text(" ").required();
  add_option(*command, "--at", arguments->at,
             "the point to follow: a corner of a tag, or a point of the world in metres "
             "(the first corner)")
      .text("TAG:CORNER|X,Y,Z");
  add_integer(*command, "--view", arguments->view, 0, "which camera of the path (0)");
  add_integer(*command, "--seed", arguments->seed, 0, "seed of the path jitter (0)");
  add_positive(*command, "--near", arguments->near_m, "distance of the near plane, m");
  add_positive(*command, "--far", arguments->far_m, "distance of the far plane, m");
  const Option json = add_flag(*command, "--json", arguments->json, "one JSON object on stdout");
  add_flag(*command, "--svg", arguments->svg,
           "a drawing on stdout: the scene with the frustum, and the image")
      .excludes(json);
  add_footer(*command, "Example: tagcal view scene.yaml --at 7:2 --svg > view.svg");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
