#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "commands/reproject_run.hpp"
#include "job/arguments.hpp"
#include "job/camera_input.hpp"
#include "job/messages.hpp"
#include "job/output_folder.hpp"
#include "job/outputs.hpp"
#include "job/picture_files.hpp"
#include "tagcal/error.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

void check_usage(const ReprojectArguments& arguments) {
  if (arguments.images.empty() && !arguments.maps && !arguments.mask)
    throw Error("no pictures given: name them, or ask for --maps or --mask");
  if (arguments.task.plane) {
    if (arguments.target.empty() && arguments.view.empty())
      throw Error(
          "--plane: needs --target (a board in the pictures) or --view (of the camera file)");
    if (arguments.view.empty() && arguments.images.empty())
      throw Error("--plane: --target needs a picture that shows the target");
    if (arguments.target.empty() && arguments.task.rectangle.empty())
      throw Error("--plane: --view needs --rectangle, or --target for its size");
    if (arguments.maps && arguments.images.size() > 1 && arguments.view.empty())
      throw Error(
          "--maps: with --plane --target there is a map for each picture: give one picture");
  } else if (!arguments.target.empty() || !arguments.view.empty()) {
    throw Error("--target, --view: belong to --plane");
  }
}

int run(const ReprojectArguments& given) {
  check_task(given.task);
  if (!given.task.rectify.empty()) return run_rectify(given);
  ReprojectArguments arguments = given;
  arguments.images.clear();
  for (const fs::path& picture : picture_files(given.images))
    arguments.images.push_back(picture.string());
  if (arguments.out.empty())
    throw Error(
        "needs --out: folder for the new pictures and their camera.yaml; see tagcal reproject "
        "--help");
  check_usage(arguments);
  const CalibrationFile file = read_camera(arguments.camera);
  ReprojectRun reprojection(arguments, file);
  reprojection.plan();
  if (!reprojection.has_plan()) {
    print_to_stderr("no picture shows the target: nothing was written\n");
    return kNoAnswer;
  }
  std::vector<fs::path> inputs(arguments.images.begin(), arguments.images.end());
  inputs.insert(inputs.end(), {arguments.camera, arguments.task.to_camera, arguments.target});
  check_new_files(arguments.out, reprojection.files(), inputs, arguments.force);
  OutputFolder folder(arguments.out, OutputFolder::Taken::by_any_folder);
  reprojection.write(folder.path());
  folder.publish();
  reprojection.say_report();
  return kAnswer;
}

void add_tasks(CLI::App& command, ReprojectTask& task) {
  add_option(command, "--undistort", task.undistort,
             "into a pinhole: all (every pixel of the picture is shown), valid (nothing but "
             "pixels of the picture), or a focal length in pixels")
      .text("all|valid|FOCAL");
  add_option(command, "--to-camera", task.to_camera, "into the picture of another camera")
      .text("OTHER.yaml");
  add_option(command, "--rotate", task.rotate,
             "turn the new camera by degrees: clockwise, upwards, to the right; alone or with "
             "another task")
      .text("ROLL,PITCH,YAW")
      .separated_by(',')
      .seldom();
  add_flag(command, "--plane", task.plane,
           "a plane seen from above, z = 0 of a board: with --m-per-px, and --target or --view");
  add_integer(command, "--pinholes", task.pinholes, 2,
              "a wide picture into several pinholes, one folder each: 5 or 6 are faces of a cube, "
              "other numbers a fan from left to right")
      .seldom();
  add_option(command, "--panorama", task.panorama, "equirectangular or cylindrical")
      .one_of({"equirectangular", "cylindrical"})
      .text("KIND");
}

void add_rectify(CLI::App& command, ReprojectTask& task) {
  add_option(command, "--rectify", task.rectify,
             "two cameras of a rig (IMAGE: a folder or picture each) with epipolar lines as equal "
             "rows; instead of --out")
      .text("DIR");
  add_option(command, "--alpha", task.alpha,
             "of --rectify: 0: only what the cameras see, to 1: all of it (as they magnify)")
      .text("A");
  add_flag(command, "--longlat", task.longlat,
           "of --rectify, for wide lenses: rows are angles about the baseline")
      .seldom();
  add_option(command, "--cameras", task.cameras,
             "of --rectify: the cameras of the rig (the names of the folders)")
      .text("LEFT,RIGHT")
      .separated_by(',')
      .seldom();
}

// Size and resolution of the new pictures.
void add_sizes(CLI::App& command, ReprojectTask& task) {
  add_option(command, "--size", task.size, "size of the undistorted picture (the camera's)")
      .text("WxH")
      .seldom();
  add_positive(command, "--px-per-deg", task.px_per_deg,
               "resolution of a panorama (that of the camera's middle)")
      .seldom();
  add_length(command, "--m-per-px", task.m_per_px, "size of a pixel of the plane in metres");
  add_option(command, "--rectangle", task.rectangle,
             "part of the plane in metres, in the board's frame (the board and a tenth more)")
      .text("X0,Y0,X1,Y1")
      .seldom()
      .separated_by(',');
  add_option(command, "--tiles", task.tiles, "cut the new picture into tiles, one folder each")
      .text("WxH")
      .seldom();
}

}  // namespace

Command add_reproject(CLI::App& app) {
  CLI::App* command = add_command(
      app, "reproject",
      "pictures as another camera, a rectified pair, a panorama or a plane would show them");
  const auto arguments = std::make_shared<ReprojectArguments>();
  add_option(*command, "IMAGE", arguments->images,
             "pictures of the camera: files, folders, patterns ('photos/*.png') or @LIST");
  add_option(*command, "--camera", arguments->camera, "the camera's calibration")
      .text("C.yaml")
      .required();
  add_option(*command, "--out", arguments->out, "folder for the new pictures and their camera.yaml")
      .text("DIR");
  add_tasks(*command, arguments->task);
  add_rectify(*command, arguments->task);
  add_sizes(*command, arguments->task);
  add_option(*command, "--target", arguments->target,
             "the board on the plane, or before the rig: a target file")
      .text("T.yaml");
  add_option(*command, "--view", arguments->view,
             "take the plane's pose from this view of the camera file")
      .text("NAME");
  add_option(*command, "--interpolation", arguments->interpolation,
             "nearest, bilinear (default) or lanczos4; the two average where pictures shrink")
      .one_of({"nearest", "bilinear", "lanczos4"})
      .text("I")
      .seldom();
  add_integer(*command, "--border", arguments->border, 0,
              "value of pixels that the camera did not see (0)")
      .seldom();
  add_flag(*command, "--mask", arguments->mask, "write mask.png: 255 where the camera saw, else 0")
      .seldom();
  add_flag(*command, "--maps", arguments->maps,
           "write map.npy for cv::remap: float32, height x width x 2 (x, y)");
  add_flag(*command, "--force", arguments->force, "replace files of an earlier run").seldom();
  add_threads(*command, arguments->threads);
  add_footer(*command,
             "Example: tagcal reproject --camera c.yaml photo.jpg --undistort all --out flat\n"
             "         tagcal reproject left right --camera rig.yaml --rectify flat");
  return {command, [arguments] { return run(*arguments); }, true};
}

}  // namespace tagcal::tools
