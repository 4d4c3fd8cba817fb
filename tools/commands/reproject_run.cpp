#include "commands/reproject_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "job/camera_input.hpp"
#include "job/find_corners.hpp"
#include "job/input.hpp"
#include "job/messages.hpp"
#include "job/picture_files.hpp"
#include "job/progress.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/estimate/view_correspondences.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/io/types.hpp"
#include "tagcal/reproject/maps.hpp"
#include "tagcal/reproject/resampling.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

struct PlaneRequest {
  std::string camera;                     // the name of a camera file,
  const CalibrationFile* file = nullptr;  // and its content
  std::string target;                     // a target file; "": none
  std::string view;                       // a view of the camera file; "": the target is detected
  std::vector<std::string> images;        // pictures
  int threads = 0;
};

struct PlanePoses {
  // Index of the picture, and its pose; with a view, that one for all pictures. Pictures without an
  // answer are not there, but in `warnings`.
  std::vector<std::pair<std::size_t, Pose>> camera_from_plane;
  std::vector<double> rectangle;  // x0, y0, x1, y1: of the target, and a tenth more; else empty
  std::vector<std::string> warnings;
};

using Points = std::map<CornerId, Eigen::Vector3d>;

std::vector<double> rectangle_around(const Points& points) {
  Eigen::AlignedBox2d box;
  for (const auto& [id, x] : points) box.extend(Eigen::Vector2d(x.head<2>()));
  const double margin = 0.1 * box.sizes().maxCoeff();
  return {box.min().x() - margin, box.min().y() - margin, box.max().x() + margin,
          box.max().y() + margin};
}

// The poses of the target in the pictures.
void estimate_poses(const PlaneRequest& request, PlanePoses& poses) {
  const CalibrationFile& file = *request.file;
  // Strict: the pictures stay those of the request, one by one.
  Input input = read_input({.target = request.target, .inputs = request.images, .strict = true});
  check_image_size(file.camera.image_size, request.camera, input);
  detect_views(input, request.threads, true, &file.camera);
  poses.warnings = input.warnings;
  const Points points = points_in_world(input.dataset.boards);
  poses.rectangle = rectangle_around(points);
  Progress progress("poses", static_cast<int>(request.images.size()));
  for (std::size_t i = 0; i < request.images.size(); ++i) {
    progress.update(static_cast<int>(i));
    const auto view = std::ranges::find(input.dataset.views, input.images[i].name, &View::image);
    PoseEstimate estimate;
    if (view != input.dataset.views.end())
      estimate =
          estimate_pose(view_correspondences(*view, points, file.camera_error_px), file.camera);
    if (is_answer(estimate.status))
      poses.camera_from_plane.emplace_back(i, estimate.camera_from_target());
    if (estimate.status != Status::ok)
      poses.warnings.push_back(fmt::format("{}: the pose of the target is {}", request.images[i],
                                           status_name(estimate.status)));
  }
}

// Throws Error for bad input.
PlanePoses plane_poses(const PlaneRequest& request) {
  PlanePoses poses;
  if (request.view.empty()) {
    estimate_poses(request, poses);
    return poses;
  }
  if (!request.target.empty()) {
    const Board board = read_target(request.target, {}, &poses.warnings);
    poses.rectangle = rectangle_around(points_in_world({{board, Pose()}}));
  }
  const Pose pose = pose_of_view(request.camera, request.view);
  for (std::size_t i = 0; i < std::max<std::size_t>(1, request.images.size()); ++i)
    poses.camera_from_plane.emplace_back(i, pose);
  return poses;
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

std::string count_text(std::ptrdiff_t count) {
  return count == 1 ? "1 picture" : fmt::format("{} pictures", count);
}

}  // namespace

ReprojectRun::ReprojectRun(const ReprojectArguments& arguments, const CalibrationFile& file)
    : arguments_(arguments),
      file_(file),
      camera_(file.camera),
      pictures_(new_pictures({arguments.images.begin(), arguments.images.end()}, file.camera,
                             arguments.camera)) {}

NewPictures new_pictures(const std::vector<fs::path>& files, const Camera& camera,
                         const std::string& camera_file) {
  NewPictures pictures;
  std::set<std::string> used;
  for (const fs::path& file : files) {
    const ImageSize size = read_image_size(file);
    if (size != camera.image_size)
      throw Error(fmt::format(
          "{}: must be {}x{} pixels as {} says, got {}x{}; if it was scaled or cut, convert the "
          "camera with --resize or --crop",
          file.string(), camera.image_size.width, camera.image_size.height, camera_file, size.width,
          size.height));
    const std::string stem = fs::path(picture_name(file)).stem().string();
    std::string name = stem + ".png";
    for (int i = 2; !used.insert(name).second; ++i) name = fmt::format("{}-{}.png", stem, i);
    pictures.files.push_back(file);
    pictures.names.push_back(name);
  }
  return pictures;
}

void write_reprojected(const fs::path& source, const Reprojection& chain,
                       const ReprojectArguments& arguments, int threads, const fs::path& file,
                       const fs::path& mask) {
  const ResampleOptions options{interpolation_of(arguments.interpolation), true, threads};
  std::visit(
      [&]<typename T>(const Image<T>& picture) {
        const Resampled<T> result =
            reproject(picture, chain, options, border_pixel<T>(arguments.border));
        write_png(file, result.image);
        if (!mask.empty()) write_png(mask, result.seen);
      },
      read_picture(source));
}

void ReprojectRun::plan() {
  if (arguments_.task.plane) return plan_plane();
  targets_ = tiled(arguments_.task, direction_targets(arguments_.task, camera_, arguments_.camera));
  poses_.resize(targets_.size());
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    poses_[t] = {{"", targets_[t].camera_from_target}};
    for (std::size_t i = 0; i < pictures_.files.size(); ++i)
      jobs_.push_back({i, t, targets_[t].camera_from_target});
  }
}

void ReprojectRun::plan_plane() {
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

bool ReprojectRun::has_common_mask() const {
  return arguments_.mask && (!arguments_.task.plane || jobs_.empty());
}

std::vector<fs::path> ReprojectRun::files() const {
  std::vector<fs::path> files;
  for (const ReprojectTarget& target : targets_) {
    const fs::path folder = target.folder;
    files.push_back(folder / target_file_name(target.target));
    if (arguments_.maps) files.push_back(folder / "map.npy");
    if (has_common_mask()) files.push_back(folder / "mask.png");
  }
  for (const Job& job : jobs_) {
    files.push_back(file_of(job));
    if (arguments_.mask && arguments_.task.plane) files.push_back(mask_of(job));
  }
  return files;
}

fs::path ReprojectRun::file_of(const Job& job) const {
  return fs::path(targets_[job.target].folder) / pictures_.names[job.picture];
}

fs::path ReprojectRun::mask_of(const Job& job) const {
  fs::path file = file_of(job);
  return file.replace_filename(file.stem().string() + "-mask.png");
}

void ReprojectRun::write(const fs::path& folder) {
  shares_.assign(targets_.size(), -1.0);
  write_targets(folder);
  Progress progress("reprojecting", static_cast<int>(jobs_.size()));
  const int own_threads = jobs_.size() == 1 ? arguments_.threads : 1;
  parallel_for(
      jobs_.size(), arguments_.threads,
      [&](std::size_t i) { write_picture(folder, jobs_[i], own_threads); },
      [&](int done, int) { progress.update(done); });
}

void ReprojectRun::write_targets(const fs::path& folder) {
  Progress progress(arguments_.maps ? "maps" : "targets", static_cast<int>(targets_.size()));
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    progress.update(static_cast<int>(t));
    write_target(folder, t);
  }
}

void ReprojectRun::write_target(const fs::path& folder, std::size_t t) {
  const ReprojectTarget& target = targets_[t];
  const fs::path place = folder / target.folder;
  fs::create_directories(place);
  write_whole(place / target_file_name(target.target),
              target_yaml(target.target, poses_[t], arguments_.camera));
  // With a target each picture has its own pose, mask and map; the pose of --view serves all.
  if (arguments_.view.empty() && poses_[t].size() > 1) return;
  const Reprojection chain{camera_, target.target, poses_[t].front().second};
  if (arguments_.maps)
    write_whole(place / "map.npy", map_npy(pixel_map(chain, arguments_.threads)));
  const Image8 seen = seen_mask(chain);
  const auto count = std::ranges::count(seen.pixels(), 255);
  shares_[t] = static_cast<double>(count) / static_cast<double>(seen.pixels().size());
  if (has_common_mask()) write_png(place / "mask.png", seen);
}

Image8 ReprojectRun::seen_mask(const Reprojection& chain) const {
  ResampleOptions options{Interpolation::nearest, false, arguments_.threads};
  return reproject(Image8(camera_.image_size), chain, options).seen;
}

void ReprojectRun::write_picture(const fs::path& folder, const Job& job, int threads) const {
  const Reprojection chain{camera_, targets_[job.target].target, job.camera_from_target};
  const bool has_mask = arguments_.mask && arguments_.task.plane;
  write_reprojected(pictures_.files[job.picture], chain, arguments_, threads, folder / file_of(job),
                    has_mask ? folder / mask_of(job) : fs::path());
}

void ReprojectRun::say_report() const {
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    const std::string& name = targets_[t].folder;
    const fs::path folder =
        name.empty() ? fs::path(arguments_.out) : arguments_.out / fs::path(name);
    const auto count = std::ranges::count(jobs_, t, &Job::target);
    say_wrote(
        folder,
        fmt::format("{}, {} ({}){}{}", count_text(count), target_file_name(targets_[t].target),
                    described(targets_[t].target), arguments_.maps ? ", map.npy" : "",
                    shares_[t] >= 0 ? fmt::format(", {:.1f} % seen", 100 * shares_[t]) : ""));
    if (shares_[t] == 0) print_to_stderr("tagcal: warning: the camera sees nothing of it\n");
  }
}

}  // namespace tagcal::tools
