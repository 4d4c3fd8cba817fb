#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "commands/commands.hpp"
#include "input/arguments.hpp"
#include "input/camera_input.hpp"
#include "input/input.hpp"
#include "input/output_folder.hpp"
#include "input/plane_poses.hpp"
#include "input/reproject_targets.hpp"
#include "report/messages.hpp"
#include "report/progress.hpp"
#include "report/reproject_files.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/text/text_file.hpp"
#include "tagcal/reproject/maps.hpp"
#include "tagcal/reproject/resampling.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string camera;
  std::vector<std::string> images;
  std::string out;
  ReprojectTask task;
  std::string target;  // of --plane
  std::string view;    // of --plane
  std::string interpolation = "bilinear";
  int border = 0;
  bool mask = false;
  bool maps = false;
  bool force = false;
  int threads = 0;
};

// The pictures of a run, which the camera took.
struct Pictures {
  std::vector<fs::path> files;
  std::vector<std::string> names;  // of the new pictures
};

Pictures pictures_of(const Arguments& arguments, const Camera& camera) {
  Pictures pictures;
  std::set<std::string> used;
  for (const std::string& image : arguments.images) {
    const fs::path file = image;
    const ImageSize size = read_image_size(file);
    if (size != camera.image_size)
      throw Error(fmt::format("{}: must be {}x{} pixels as {} says, got {}x{}", image,
                              camera.image_size.width, camera.image_size.height, arguments.camera,
                              size.width, size.height));
    std::string name = file.stem().string() + ".png";
    for (int i = 2; !used.insert(name).second; ++i)
      name = fmt::format("{}-{}.png", file.stem().string(), i);
    pictures.files.push_back(file);
    pictures.names.push_back(name);
  }
  return pictures;
}

Interpolation interpolation_of(const std::string& name) {
  if (name == "nearest") return Interpolation::nearest;
  return name == "lanczos4" ? Interpolation::lanczos4 : Interpolation::bilinear;
}

// The border value in all values of a pixel.
template <typename T>
T border_pixel(int border) {
  const int value = std::min(border, sizeof(T) % 2 == 0 ? 65535 : 255);
  if constexpr (std::is_integral_v<T>) {
    return static_cast<T>(value);
  } else {
    T pixel;
    pixel.fill(static_cast<typename T::value_type>(value));
    return pixel;
  }
}

// One new picture of one picture.
struct Job {
  std::size_t picture = 0;
  std::size_t target = 0;
  Pose camera_from_target;
};

class Run {
 public:
  Run(const Arguments& arguments, const CalibrationFile& file, Pictures pictures)
      : arguments_(arguments), file_(file), camera_(file.camera), pictures_(std::move(pictures)) {}

  // Fills in targets, and the pictures that go through them.
  void plan() {
    if (arguments_.task.plane) return plan_plane();
    targets_ =
        tiled(arguments_.task, direction_targets(arguments_.task, camera_, arguments_.camera));
    poses_.resize(targets_.size());
    for (std::size_t t = 0; t < targets_.size(); ++t) {
      poses_[t] = {{"", targets_[t].camera_from_target}};
      for (std::size_t i = 0; i < pictures_.files.size(); ++i)
        jobs_.push_back({i, t, targets_[t].camera_from_target});
    }
  }

  bool has_plan() const { return !targets_.empty(); }

  // Names of the files to be written, relative to the folder.
  std::vector<fs::path> files() const {
    std::vector<fs::path> files;
    for (const ReprojectTarget& target : targets_) {
      const fs::path folder = target.folder;
      files.push_back(folder / target_file_name(target.target));
      if (arguments_.maps) files.push_back(folder / "map.npy");
      if (arguments_.mask && !arguments_.task.plane) files.push_back(folder / "mask.png");
    }
    for (const Job& job : jobs_) {
      files.push_back(file_of(job));
      if (arguments_.mask && arguments_.task.plane) files.push_back(mask_of(job));
    }
    return files;
  }

  void write(const fs::path& folder) {
    shares_.assign(targets_.size(), -1.0);
    write_targets(folder);
    Progress progress("reprojecting", static_cast<int>(jobs_.size()));
    const int own_threads = jobs_.size() == 1 ? arguments_.threads : 1;
    parallel_for(
        jobs_.size(), arguments_.threads,
        [&](std::size_t i) { write_picture(folder, jobs_[i], own_threads); },
        [&](int done, int) { progress.update(done); });
  }

  std::string report() const {
    std::string text;
    for (std::size_t t = 0; t < targets_.size(); ++t) {
      const std::string& name = targets_[t].folder;
      const fs::path folder =
          name.empty() ? fs::path(arguments_.out) : arguments_.out / fs::path(name);
      const auto count = std::ranges::count(jobs_, t, &Job::target);
      text += fmt::format("wrote {}: {}, {} ({}){}{}\n", folder.string(), count_text(count),
                          target_file_name(targets_[t].target), described(targets_[t].target),
                          arguments_.maps ? ", map.npy" : "",
                          shares_[t] >= 0 ? fmt::format(", {:.1f} % seen", 100 * shares_[t]) : "");
      if (shares_[t] == 0) text += "warning: the camera sees nothing of it\n";
    }
    return text;
  }

 private:
  static std::string count_text(std::ptrdiff_t count) {
    return count == 1 ? "1 picture" : fmt::format("{} pictures", count);
  }

  void plan_plane() {
    const PlanePoses found = plane_poses({arguments_.camera, &file_, arguments_.target,
                                          arguments_.view, arguments_.images, arguments_.threads});
    print_warnings(found.warnings);
    if (found.camera_from_plane.empty()) return;
    const PlaneRaster raster = plane_raster(arguments_.task, found.rectangle);
    targets_ = tiled(arguments_.task, {{"", raster, Pose()}});
    poses_.resize(targets_.size());
    for (std::size_t t = 0; t < targets_.size(); ++t) {
      for (const auto& [i, pose] : found.camera_from_plane) {
        const bool has_picture = i < pictures_.names.size();  // none: for maps alone
        poses_[t].emplace_back(has_picture ? pictures_.names[i] : "", pose);
        if (has_picture) jobs_.push_back({i, t, pose});
      }
    }
  }

  fs::path file_of(const Job& job) const {
    return fs::path(targets_[job.target].folder) / pictures_.names[job.picture];
  }
  fs::path mask_of(const Job& job) const {
    fs::path file = file_of(job);
    return file.replace_filename(file.stem().string() + "-mask.png");
  }

  void write_targets(const fs::path& folder) {
    Progress progress(arguments_.maps ? "maps" : "targets", static_cast<int>(targets_.size()));
    for (std::size_t t = 0; t < targets_.size(); ++t) {
      progress.update(static_cast<int>(t));
      write_target(folder, t);
    }
  }

  void write_target(const fs::path& folder, std::size_t t) {
    const ReprojectTarget& target = targets_[t];
    const fs::path place = folder / target.folder;
    fs::create_directories(place);
    write_whole(place / target_file_name(target.target),
                target_yaml(target.target, poses_[t], arguments_.camera));
    if (arguments_.task.plane && poses_[t].size() > 1) return;  // a mask and a map for each pose
    const Reprojection chain{camera_, target.target, poses_[t].front().second};
    if (arguments_.maps)
      write_whole(place / "map.npy", map_npy(pixel_map(chain, arguments_.threads)));
    const Image8 seen = seen_mask(chain);
    const auto count = std::ranges::count(seen.pixels(), 255);
    shares_[t] = static_cast<double>(count) / static_cast<double>(seen.pixels().size());
    if (arguments_.mask && !arguments_.task.plane) write_png(place / "mask.png", seen);
  }

  Image8 seen_mask(const Reprojection& chain) const {
    ResampleOptions options{Interpolation::nearest, false, arguments_.threads};
    return reproject(Image8(camera_.image_size), chain, options).seen;
  }

  void write_picture(const fs::path& folder, const Job& job, int threads) const {
    const ResampleOptions options{interpolation_of(arguments_.interpolation), true, threads};
    const Reprojection chain{camera_, targets_[job.target].target, job.camera_from_target};
    std::visit(
        [&]<typename T>(const Image<T>& picture) {
          const Resampled<T> result =
              reproject(picture, chain, options, border_pixel<T>(arguments_.border));
          write_png(folder / file_of(job), result.image);
          if (arguments_.mask && arguments_.task.plane)
            write_png(folder / mask_of(job), result.seen);
        },
        read_picture(pictures_.files[job.picture]));
  }

  const Arguments& arguments_;
  const CalibrationFile& file_;
  const Camera& camera_;
  Pictures pictures_;
  std::vector<ReprojectTarget> targets_;
  std::vector<NamedPoses> poses_;  // of each target
  std::vector<Job> jobs_;
  std::vector<double> shares_;  // of the pixels of each target that are seen; -1: not known
};

// Refuses to replace files, what the command reads even with --force.
void check_not_replaced(const Arguments& arguments, const std::vector<fs::path>& files) {
  std::error_code none;
  for (const fs::path& name : files) {
    const fs::path file = fs::path(arguments.out) / name;
    if (!fs::exists(file, none)) continue;
    std::vector<std::string> sources = arguments.images;
    sources.insert(sources.end(), {arguments.camera, arguments.task.to_camera, arguments.target});
    for (const std::string& source : sources)
      if (!source.empty() && fs::equivalent(file, source, none))
        throw Error(fmt::format("{}: would be replaced by the result: take another --out", source));
    if (!arguments.force)
      throw Error(
          fmt::format("{}: exists: take another --out, or --force to replace it", file.string()));
  }
}

void check_usage(const Arguments& arguments) {
  check_task(arguments.task);
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

int run(const Arguments& arguments) {
  check_usage(arguments);
  const CalibrationFile file = read_camera(arguments.camera);
  Run reprojection(arguments, file, pictures_of(arguments, file.camera));
  reprojection.plan();
  if (!reprojection.has_plan()) {
    print_to_stderr("no picture shows the target: nothing was written\n");
    return kNoAnswer;
  }
  check_not_replaced(arguments, reprojection.files());
  OutputFolder folder(arguments.out, OutputFolder::Taken::by_any_folder);
  reprojection.write(folder.path());
  folder.publish();
  print_to_stderr("{}", reprojection.report());
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
      .separated_by(',');
  add_flag(command, "--plane", task.plane,
           "a plane seen from above, z = 0 of a board: with --m-per-px, and --target or --view");
  add_integer(command, "--pinholes", task.pinholes, 2,
              "a wide picture into several pinholes, one folder each: 5 or 6 are faces of a cube, "
              "other numbers a fan from left to right");
  add_option(command, "--panorama", task.panorama, "equirectangular or cylindrical")
      .one_of({"equirectangular", "cylindrical"})
      .text("KIND");
  add_option(command, "--size", task.size, "size of the undistorted picture (the camera's)")
      .text("WxH");
  add_positive(command, "--px-per-deg", task.px_per_deg,
               "resolution of a panorama (that of the camera's middle)");
  add_positive(command, "--m-per-px", task.m_per_px, "size of a pixel of the plane in metres");
  add_option(command, "--rectangle", task.rectangle,
             "part of the plane in metres, in the board's frame (the board and a tenth more)")
      .text("X0,Y0,X1,Y1")
      .separated_by(',');
  add_option(command, "--tiles", task.tiles, "cut the new picture into tiles, one folder each")
      .text("WxH");
}

}  // namespace

Command add_reproject(CLI::App& app) {
  CLI::App* command = add_command(
      app, "reproject", "pictures as another camera, a panorama or a plane would show them");
  const auto arguments = std::make_shared<Arguments>();
  add_option(*command, "IMAGE", arguments->images, "pictures of the camera").text(" ");
  add_option(*command, "--camera", arguments->camera, "the camera's calibration")
      .text("C.yaml REQUIRED")
      .required();
  add_option(*command, "--out", arguments->out, "folder for the new pictures and their camera.yaml")
      .text("DIR REQUIRED")
      .required();
  add_tasks(*command, arguments->task);
  add_option(*command, "--target", arguments->target, "the board on the plane: a target file")
      .text("T.yaml");
  add_option(*command, "--view", arguments->view,
             "take the plane's pose from this view of the camera file")
      .text("NAME");
  add_option(*command, "--interpolation", arguments->interpolation,
             "nearest, bilinear (default) or lanczos4; the two average where pictures shrink")
      .one_of({"nearest", "bilinear", "lanczos4"})
      .text("I");
  add_integer(*command, "--border", arguments->border, 0,
              "value of pixels that the camera did not see (0)");
  add_flag(*command, "--mask", arguments->mask, "write mask.png: 255 where the camera saw, else 0");
  add_flag(*command, "--maps", arguments->maps,
           "write map.npy for cv::remap: float32, height x width x 2 (x, y)");
  add_flag(*command, "--force", arguments->force, "replace files of an earlier run");
  add_threads(*command, arguments->threads);
  add_footer(
      *command,
      "Example: tagcal reproject --camera camera.yaml photo.jpg --undistort all --out flat\n"
      "         tagcal reproject --camera camera.yaml photo.jpg --plane --target board.yaml \\\n"
      "                          --m-per-px 0.001 --out top");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
