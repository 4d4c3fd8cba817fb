#include "job/view_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "job/camera_input.hpp"
#include "job/find_corners.hpp"
#include "job/messages.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/estimate/view_correspondences.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/scene_file.hpp"
#include "tagcal/viewing/projection.hpp"

namespace tagcal::tools {
namespace {

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

}  // namespace

ViewInput read_view_input(const ViewChoice& choice) {
  const bool is_dataset = std::filesystem::is_directory(choice.input);
  if (!is_dataset && !choice.camera.empty())
    throw Error("--camera: belongs to a data set, the folder of one");
  if (!is_dataset && !is_calibration(choice.input)) return scene_input(choice);
  if (choice.seed >= 0) throw Error("--seed: belongs to a scene, whose path may have jitter");
  return is_dataset ? dataset_input(choice) : calibration_input(choice);
}

}  // namespace tagcal::tools
