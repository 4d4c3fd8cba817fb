#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "draw/canvas.hpp"
#include "draw/view_panels.hpp"
#include "job/arguments.hpp"
#include "job/camera_input.hpp"
#include "job/find_corners.hpp"
#include "job/input.hpp"
#include "job/messages.hpp"
#include "job/plain_text.hpp"
#include "report/view_text.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/estimate/view_correspondences.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/scene_file.hpp"
#include "tagcal/scene/moving_scene.hpp"
#include "tagcal/viewing/projection.hpp"

namespace tagcal::tools {
namespace {

struct ViewChoice {
  std::string input;   // a scene, the folder of a data set, or a calibration
  std::string camera;  // a calibration for a data set; "": the truth's camera and poses
  int view = 0;
  int seed = -1;  // of a scene's jitter; -1: not given
};

// One camera, and the scene in front of it: that of a data set has boards only, that of a
// calibration nothing.
struct ViewInput {
  MovingScene scene;
  std::string image;                      // the name of the view, or of the calibration
  std::optional<Pose> camera_from_world;  // none: the view does not determine it
  std::vector<std::string> warnings;
};

void check_view(int view, std::size_t num_views, const std::string& input) {
  if (num_views == 0) throw Error(input + ": has no views");
  if (static_cast<std::size_t>(view) >= num_views)
    throw Error(fmt::format("--view: must be {} at most, of the views in {}, got {}", num_views - 1,
                            input, view));
}

ViewInput scene_input(const ViewChoice& choice) {
  ViewInput result;
  result.scene = read_moving_scene(choice.input, &result.warnings);
  check_view(choice.view, static_cast<std::size_t>(result.scene.settings.num_views), choice.input);
  result.image = image_name(choice.view);
  const auto seed = static_cast<std::uint64_t>(std::max(0, choice.seed));
  const auto poses = naming(choice.input, [&] { return camera_poses(result.scene, seed); });
  result.camera_from_world = poses[static_cast<std::size_t>(choice.view)];
  return result;
}

void set_camera(ViewInput& input, const Camera& camera, const std::string& model) {
  input.scene.settings.camera = camera;
  input.scene.settings.model = model.empty() ? std::string(kind_of(camera.lens).name) : model;
}

void look_by_truth(const Input& input, const ViewChoice& choice, ViewInput& result) {
  if (!input.dataset.truth)
    throw Error(choice.input + ": has no truth: a calibration is needed, --camera C.yaml");
  const Truth& truth = *input.dataset.truth;
  check_view(choice.view, truth.camera_from_world.size(), choice.input);
  const auto& [image, pose] = *std::next(truth.camera_from_world.begin(), choice.view);
  result.image = image;
  result.camera_from_world = pose;
  set_camera(result, truth.camera, truth.model);
  if (const auto lens = truth.lenses.find(image); lens != truth.lenses.end())
    result.scene.settings.camera.lens = lens->second;
}

void look_by_calibration(Input& input, const ViewChoice& choice, ViewInput& result) {
  const CalibrationFile file = read_camera(choice.camera);
  check_image_size(file.camera.image_size, choice.camera, input);
  set_camera(result, file.camera, file.model);
  find_views(input, 0, true, &file.camera);
  check_view(choice.view, input.dataset.views.size(), choice.input);
  const View& view = input.dataset.views[static_cast<std::size_t>(choice.view)];
  const PoseEstimate pose = estimate_pose(
      view_correspondences(view, input.dataset.boards, file.camera_error_px), file.camera);
  result.image = view.image;
  for (const Finding& finding : pose.findings) result.warnings.push_back(finding.sentence);
  if (is_answer(pose.status)) result.camera_from_world = pose.camera_from_target();
}

ViewInput dataset_input(const ViewChoice& choice) {
  InputArguments arguments;
  arguments.inputs = {choice.input};
  Input input = read_input(arguments);
  ViewInput result;
  for (const PlacedBoard& board : input.dataset.boards)
    result.scene.boards.push_back({kWorldFrame, board});
  if (choice.camera.empty())
    look_by_truth(input, choice, result);
  else
    look_by_calibration(input, choice, result);
  result.warnings.insert(result.warnings.begin(), input.warnings.begin(), input.warnings.end());
  return result;
}

// The camera stands at the world's origin and looks along y.
ViewInput calibration_input(const ViewChoice& choice) {
  const CalibrationFile file = read_camera(choice.input);
  ViewInput result;
  check_view(choice.view, 1, choice.input);
  set_camera(result, file.camera, file.model);
  result.image = std::filesystem::path(choice.input).filename().string();
  result.camera_from_world =
      Pose(camera_from_world_drawn(DrawnView::front_elevation), Eigen::Vector3d::Zero());
  return result;
}

// A file of any format, or one of its cameras, "FILE:NAME".
bool is_calibration(const std::string& input) {
  std::error_code error;
  return !std::filesystem::exists(input, error) || is_camera_file(input);
}

// Recognises the kind of input by itself. Throws Error.
ViewInput read_view_input(const ViewChoice& choice) {
  const bool is_dataset = std::filesystem::is_directory(choice.input);
  if (!is_dataset && !choice.camera.empty())
    throw Error("--camera: belongs to a data set, the folder of one");
  if (!is_dataset && !is_calibration(choice.input)) return scene_input(choice);
  if (choice.seed >= 0) throw Error("--seed: belongs to a scene, whose path may have jitter");
  return is_dataset ? dataset_input(choice) : calibration_input(choice);
}

struct ViewArguments {
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

ViewingPipeline pipeline_of(const ViewArguments& arguments, const Scene& scene, const Pose& pose) {
  NearFar planes = enclosing_planes(scene, pose);
  if (scene.boards.empty()) planes = {0.5, 1.5};  // m; about the point 1 m ahead
  if (arguments.near_m > 0) planes.near_m = arguments.near_m;
  if (arguments.far_m > 0) planes.far_m = arguments.far_m;
  if (!(planes.near_m < planes.far_m))
    throw Error(
        fmt::format("--near: must be < far, got {:g} and {:g} m", planes.near_m, planes.far_m));
  return viewing_pipeline(scene.camera, pose, planes.near_m, planes.far_m);
}

std::string report_text(const ViewArguments& arguments, const ViewReport& report) {
  if (arguments.json) return view_json(report);
  if (arguments.svg) return drawing_svg(view_drawing(report));
  return arguments.opengl ? view_opengl(report) : view_text(report, arguments.steps);
}

std::string answer(const ViewArguments& arguments, const ViewInput& input) {
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

int run(const ViewArguments& arguments) {
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
void add_printed_forms(CLI::App& command, ViewArguments& arguments, Option& to) {
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
  const auto arguments = std::make_shared<ViewArguments>();
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
