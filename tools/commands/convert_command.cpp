#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "commands/commands.hpp"
#include "commands/convert_model.hpp"
#include "job/arguments.hpp"
#include "job/camera_input.hpp"
#include "job/find_corners.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "job/reproject_targets.hpp"
#include "job/terminal.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/corners_file.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal::tools {
namespace {

struct ConvertArguments {
  std::string in;
  std::string out;
  std::string format;
  std::string image_size;
  std::string crop;    // X,Y,WIDTHxHEIGHT
  std::string resize;  // WIDTHxHEIGHT
  ModelArguments model;
  std::string poses;   // of `tagcal pose --json`; "": those of IN
  std::string target;  // of corners; "": a camera
};

// The size that the user states; 0 x 0: none.
ImageSize stated_size(const ConvertArguments& arguments) {
  return arguments.image_size.empty() ? ImageSize()
                                      : size_argument("--image-size", arguments.image_size);
}

// Fills in the image size where the file has none.
void add_image_size(CameraFile& file, const ConvertArguments& arguments) {
  if (arguments.image_size.empty()) return;
  const ImageSize size = stated_size(arguments);
  for (FileCamera& camera : file.cameras) {
    ImageSize& own = camera.calibration.camera.image_size;
    if (own != ImageSize{} && own != size)
      throw Error(
          fmt::format("--image-size: {} says {}x{}, got {}; --resize makes the camera of "
                      "scaled pictures, --crop that of a part",
                      arguments.in, own.width, own.height, arguments.image_size));
    own = size;
  }
}

// "X,Y,WIDTHxHEIGHT"
PixelRectangle rectangle_argument(const std::string& text) {
  PixelRectangle part;
  int used = 0;
  if (std::sscanf(text.c_str(), "%d,%d,%n", &part.x, &part.y, &used) != 2 || used == 0)
    throw Error(fmt::format("--crop: must be X,Y,WIDTHxHEIGHT, got {}", text));
  part.size = size_argument("--crop", text.substr(static_cast<std::size_t>(used)));
  return part;
}

// Notes a scale that differs along x and y: pictures of another aspect ratio are mostly a part.
void note_aspect(const ImageSize& from, const ImageSize& to, std::vector<std::string>& notes) {
  constexpr double kRounding = 1;  // numeric: px of `from`, by sides that are whole numbers
  const double x = static_cast<double>(to.width) / from.width;
  const double y = static_cast<double>(to.height) / from.height;
  if (std::abs(y - x) * std::min(from.width, from.height) <= kRounding) return;
  const std::string note = fmt::format(
      "--resize: {}x{} to {}x{} scales x by {:.4g} and y by {:.4g}, which makes fx and "
      "fy differ: if the pictures are a part of the old ones, state it by --crop",
      from.width, from.height, to.width, to.height, x, y);
  if (std::ranges::find(notes, note) == notes.end()) notes.push_back(note);
}

// What IN says of the lenses that --model, --crop or --resize replaces.
void drop_what_is_of_other_lenses(CameraFile& file, const ConvertArguments& arguments) {
  if (arguments.model.model.empty() && arguments.crop.empty() && arguments.resize.empty()) return;
  bool has_findings = !file.findings.empty();
  file.findings.clear();
  for (FileCamera& camera : file.cameras) {
    has_findings = has_findings || !camera.calibration.findings.empty();
    camera.calibration.findings.clear();
  }
  if (has_findings)
    file.notes.emplace_back(
        "dropped: the warnings of the calibration, which belong to the lenses of IN");
  if (arguments.model.model.empty()) return;
  if (file.rig_covariance.size() > 0)
    file.notes.emplace_back(
        "dropped: the covariance of the rig, which belongs to the lenses of IN");
  file.rig_covariance.resize(0, 0);
}

// The cameras of pictures that are a part of those of the file, or scaled, or both in this order.
void cut_and_scale(CameraFile& file, const ConvertArguments& arguments) {
  if (arguments.crop.empty() && arguments.resize.empty()) return;
  std::vector<Camera> cameras;
  for (const FileCamera& in_file : file.cameras) {
    const CalibrationFile& known = in_file.calibration;
    if (known.camera.image_size == ImageSize{})
      throw Error(fmt::format("{}: {} has no image size; state it by --image-size",
                              arguments.resize.empty() ? "--crop" : "--resize", arguments.in));
    Camera camera = known.camera;
    if (!arguments.crop.empty()) {
      const PixelRectangle part = rectangle_argument(arguments.crop);
      const ImageSize& all = camera.image_size;
      if (part.x < 0 || part.y < 0 || part.x > all.width - part.size.width ||
          part.y > all.height - part.size.height)
        throw Error(fmt::format("--crop: {} is not inside the image of {}x{}", arguments.crop,
                                all.width, all.height));
      camera = cropped(camera, part);
    }
    if (!arguments.resize.empty()) {
      const ImageSize size = size_argument("--resize", arguments.resize);
      note_aspect(camera.image_size, size, file.notes);
      camera = resized(camera, size);
    }
    cameras.push_back(camera);
  }
  put_on_pixels(file, cameras);
}

// Cameras that lack the size that the format holds.
void check_image_sizes(const CameraFile& file, const ConvertArguments& arguments,
                       const CameraFormat& format) {
  if (format.only_poses) return;
  for (const FileCamera& camera : file.cameras)
    if (camera.calibration.camera.image_size == ImageSize{})
      throw Error(fmt::format("{}: has no image size, which {} needs: state it by --image-size",
                              arguments.in, format.name));
}

std::vector<std::string> names_of_formats() {
  std::vector<std::string> names;
  for (const CameraFormat& format : camera_formats()) names.emplace_back(format.name);
  return names;
}

std::string format_of(const ConvertArguments& arguments) {
  if (!arguments.format.empty()) return arguments.format;
  const std::string_view format = format_of_name(arguments.out);
  if (!format.empty()) return std::string(format);
  const std::string what = arguments.out == kStdout
                               ? "standard output has no name that says the format"
                               : arguments.out + ": its name does not say the format";
  throw Error(fmt::format("{}: choose one by --to: {}", what, alternatives(names_of_formats())));
}

// True if OUT is a folder: of all cameras of a format with a file for each, or of a stereo pair.
bool writes_folder(const ConvertArguments& arguments, const CameraFormat& format) {
  const std::filesystem::path out = arguments.out;
  std::error_code error;
  return format.folder || ((format.pair || !format.each.empty()) &&
                           (std::filesystem::is_directory(out, error) || !out.has_extension()));
}

// All cameras of the file for a format that holds several, or as many files, else one.
CameraFile read_cameras(const ConvertArguments& arguments, const CameraFormat& format) {
  std::error_code error;
  if ((format.several || format.pair || writes_folder(arguments, format)) &&
      std::filesystem::exists(arguments.in, error))
    return read_camera_file(arguments.in, stated_size(arguments));
  return read_one_camera(arguments.in, stated_size(arguments));
}

// A file of OpenCV's sample may have both a camera and corners.
bool is_camera_too(const std::string& file) {
  try {
    return is_camera_file(file);
  } catch (const Error&) {
    return false;
  }
}

int convert_corners(const ConvertArguments& arguments) {
  std::vector<std::string> notes;
  const std::vector<PlacedBoard> boards = {{read_target(arguments.target, {}, &notes), Pose()}};
  const std::vector<View> views = read_observations(arguments.in, boards, &notes);
  const std::string format = arguments.format.empty()
                                 ? std::string(corners_format_of_name(arguments.out))
                                 : arguments.format;
  if (format.empty())
    throw Error(fmt::format("{}: must end in .csv, .vnl, .yaml, .xml or .json, or take --to",
                            arguments.out));
  check_text_writable(arguments.out);
  const std::vector<std::string> dropped = write_corners(arguments.out, views, boards, format);
  hold_notes(arguments.in, notes);
  hold_notes(arguments.out, dropped);
  say_wrote(arguments.out,
            fmt::format("{}, {}, {}", format, counted(views.size(), "view"),
                        counted(static_cast<std::size_t>(num_corners(views)), "corner")));
  return kAnswer;
}

void check_corner_usage(const ConvertArguments& arguments) {
  if (!arguments.model.model.empty())
    throw Error("--model: fits the lens of a camera, --target converts corners: take one");
  if (!arguments.poses.empty())
    throw Error("--poses: belongs to a camera, --target converts corners: take one");
  for (const auto& [option, value] : {std::pair("--image-size", &arguments.image_size),
                                      {"--crop", &arguments.crop},
                                      {"--resize", &arguments.resize}})
    if (!value->empty())
      throw Error(
          fmt::format("{}: belongs to a camera, --target converts corners: take one", option));
}

void say_converted(const std::string& out, const CameraFile& file, const CameraFormat& format,
                   const std::vector<std::string>& notes) {
  const bool dropped = std::ranges::any_of(
      notes, [](const std::string& note) { return note.starts_with("dropped: the poses"); });
  const std::size_t num_poses = dropped ? 0 : file.poses.size();
  say_wrote(out, fmt::format("{}, from {}: {}, {}", format.name, file.format,
                             counted(file.cameras.size(), "camera"), counted(num_poses, "pose")));
}

int run(const ConvertArguments& arguments) {
  check_usage(arguments.model);
  check_replaces_nothing({arguments.out, arguments.model.picture},
                         {arguments.in, arguments.in.substr(0, arguments.in.rfind(':')),
                          arguments.target, arguments.poses});  // IN may be FILE:NAME
  if (!arguments.target.empty()) {
    check_corner_usage(arguments);
    return convert_corners(arguments);
  }
  std::error_code error;
  if (std::filesystem::is_regular_file(arguments.in, error) && is_corners_file(arguments.in) &&
      !is_camera_too(arguments.in))
    throw Error(fmt::format("{}: has corners: --target T.yaml names their board", arguments.in));
  const CameraFormat& format =
      *std::ranges::find(camera_formats(), format_of(arguments), &CameraFormat::name);
  if (!writes_folder(arguments, format)) check_text_writable(arguments.out);
  CameraFile file = read_cameras(arguments, format);
  add_image_size(file, arguments);
  drop_what_is_of_other_lenses(file, arguments);
  cut_and_scale(file, arguments);
  if (!fit_models(file, arguments.in, arguments.model, arguments.out)) return kCheckFailed;
  check_image_sizes(file, arguments, format);
  if (!arguments.poses.empty()) {
    if (file.cameras.size() > 1) {
      throw Error(fmt::format("--poses: belongs to one camera, {} has {}: choose one by {}:NAME",
                              arguments.in, file.cameras.size(), arguments.in));
    }
    file.poses = read_poses(arguments.poses);
    file.frame_of_poses = "target";
  }
  const std::vector<std::string> notes = write_camera_file(arguments.out, file, format.name);
  hold_notes(arguments.in, file.notes);
  hold_notes(arguments.out, notes);
  say_converted(arguments.out, file, format, notes);
  return kAnswer;
}

// The endings of names that stand for a format.
std::string known_names() {
  std::string names;
  for (const CameraFormat& format : camera_formats())
    if (!format.ending.empty())
      names += fmt::format("{}{}{}", names.empty() ? "" : ", ", format.ending[0] == '.' ? "x" : "",
                           format.ending);
  return names;
}

std::string notes() {
  std::string text =
      wrapped(
          "",
          "The format of IN is recognised by its content; it may be a folder with a file for each "
          "camera of a rig. IN:NAME chooses one of several cameras. Every --camera option takes "
          "the same files.",
          0) +
      "\nFormats of --to:\n";
  for (const CameraFormat& format : camera_formats())
    text += wrapped(fmt::format("  {:<11} ", format.name), format.program, 14) +
            wrapped(std::string(16, ' '), "lenses: " + std::string(format.lenses), 24);
  return text.substr(0, text.size() - 1);
}

void add_sizes(CLI::App& command, ConvertArguments& arguments) {
  add_option(command, "--image-size", arguments.image_size,
             "pixels of the pictures, where IN does not say")
      .text("WIDTHxHEIGHT");
  add_option(command, "--crop", arguments.crop,
             "the camera of this part of its pictures; X,Y is the part's top-left pixel")
      .text("X,Y,WIDTHxHEIGHT");
  add_option(command, "--resize", arguments.resize,
             "the camera of its pictures (or the part) scaled or binned to this size")
      .text("WIDTHxHEIGHT");
}

}  // namespace

Command add_convert(CLI::App& app) {
  CLI::App* command =
      add_command(app, "convert", "a camera, its poses or corners from and to files of others");
  const auto arguments = std::make_shared<ConvertArguments>();
  add_option(*command, "IN", arguments->in, "a camera's file, or FILE:NAME").required();
  add_option(
      *command, "OUT", arguments->out,
      "the file to write; a folder for colmap, and for a rig in formats with a file a camera")
      .writes_text()
      .required();
  add_option(*command, "--to", arguments->format,
             "the format of OUT; default: the one that its name stands for (" + known_names() + ")")
      .one_of(names_of_formats())
      .text("FORMAT");
  add_sizes(*command, *arguments);
  add_model_options(*command, arguments->model);
  add_option(*command, "--poses", arguments->poses,
             "poses of pictures instead of those of IN: the output of tagcal pose --json")
      .text("JSON")
      .seldom();
  add_option(*command, "--target", arguments->target,
             "convert corners of this board (a target file), not a camera: CSV, corners.vnl of "
             "mrcal, image_points of OpenCV (YAML, XML, JSON)")
      .text("T.yaml");
  add_footer(*command,
             "Example: tagcal convert camera.yaml front.cameramodel\n"
             "         tagcal convert camchain.yaml:cam1 right.yaml --to ros\n"
             "         tagcal convert camera.yaml sparse --to colmap\n"
             "         tagcal convert rig.yaml models --to mrcal\n"
             "         tagcal convert camera.yaml half.yaml --to tagcal --resize 640x480\n"
             "         tagcal convert camchain.yaml:cam0 camera.yaml --model fisheye4\n"
             "         tagcal convert corners.vnl corners.csv --target board.yaml",
             notes());
  return {command, [arguments] { return run(*arguments); }, true};
}

}  // namespace tagcal::tools
